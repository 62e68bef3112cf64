//! The host's rounding, flush-to-zero and trap modes must not change a result: calls run in the default modes.

/// The default modes, in force until this is dropped; then the host's are back as they were.
pub(crate) struct DefaultModes {
    host: Control,
}

impl DefaultModes {
    pub fn enter() -> Self {
        let host = read();
        write(DEFAULT);
        DefaultModes { host }
    }
}

impl Drop for DefaultModes {
    fn drop(&mut self) {
        write(self.host);
    }
}

#[cfg(target_arch = "x86_64")]
use x86_64::{Control, DEFAULT, read, write};

/// MXCSR: what SSE and AVX obey, and with them all arithmetic on `f64`.
#[cfg(target_arch = "x86_64")]
mod x86_64 {
    use std::arch::asm;

    pub type Control = u32;

    /// To nearest, denormal numbers kept, all traps masked.
    pub const DEFAULT: Control = 0x1f80;

    pub fn read() -> Control {
        let mut control: Control = 0;
        // SAFETY: the instruction writes the four bytes that it is given.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags)) };
        control
    }

    pub fn write(control: Control) {
        // SAFETY: the value comes from `read` or is the default, so no reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack, preserves_flags, readonly)) };
    }
}

/// Other processors are left in the modes of the host.
#[cfg(not(target_arch = "x86_64"))]
use other::{Control, DEFAULT, read, write};

#[cfg(not(target_arch = "x86_64"))]
mod other {
    pub type Control = ();
    pub const DEFAULT: Control = ();
    pub fn read() -> Control {}
    pub fn write((): Control) {}
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn rounding_and_denormal_numbers_are_the_default_ones_inside_and_the_hosts_after() {
        const UPWARD_AND_FLUSHING: Control = DEFAULT | 0x4000 | 0x8040;
        let third = || black_box(1.0) / black_box(3.0);
        let tiny = || black_box(f64::MIN_POSITIVE) / black_box(2.0);
        let (nearest, denormal) = (third(), tiny());
        write(UPWARD_AND_FLUSHING);
        let outside = (third(), tiny());
        let inside = {
            let _modes = DefaultModes::enter();
            (third(), tiny())
        };
        let after = read() & !0x3f;
        write(DEFAULT);
        assert!(outside.0 > nearest && outside.1 == 0.0, "the host's modes had no effect: {outside:?}");
        assert_eq!(inside, (nearest, denormal));
        assert_eq!(after, UPWARD_AND_FLUSHING);
    }
}
