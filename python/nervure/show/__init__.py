"""What people look at: pictures, fields, animations, tables, progress."""
