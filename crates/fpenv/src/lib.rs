//! Floating-point modes of a thread.
//!
//! [`Fast`] rounds to nearest, replaces denormal numbers (below 2.2e-308) by zero, masks all traps, and restores the
//! modes of the host at the end. Results then do not depend on the modes of the host. A flow that comes to rest
//! consists of denormal numbers, and arithmetic with them is slow. On Linux a thread inherits the modes of its parent,
//! on other systems it starts with default modes; [`Modes::apply`] copies them.
//!
//! # Assumptions of the compiler
//!
//! Rust and LLVM assume the default modes: rounding to nearest, denormal numbers kept, traps masked. The documentation
//! of `core::arch::x86_64::_mm_setcsr` calls a change of modes undefined behaviour, even without arithmetic, unless one
//! assembly block makes and undoes it. [`Fast`] differs from the default in the treatment of denormal numbers, so this
//! crate is outside of what the language promises. Its users depend on what compilers do with the assumption:
//!
//! - The compiler evaluates constant expressions with denormal numbers kept. No result may depend on a constant
//!   expression with denormal values.
//! - The compiler may move arithmetic across a change of modes. A caller passes operands and results through
//!   [`std::hint::black_box`] inside the scope of [`Fast`], as `nervure-fmi-export` does.

/// Modes of rounding, denormal numbers and traps of a thread; on x86-64 with the exception flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modes(Control);

impl Modes {
    /// Return the modes of this thread.
    pub fn of_thread() -> Self {
        Modes(read())
    }

    /// Set the modes of this thread.
    pub fn apply(self) {
        write(self.0);
    }
}

/// Guard: rounding to nearest without denormal numbers, until its drop restores the modes of the host.
pub struct Fast {
    host: Modes,
}

impl Fast {
    /// Store the modes of the host and set the fast modes.
    pub fn enter() -> Self {
        let host = Modes::of_thread();
        Modes(FAST).apply();
        Fast { host }
    }
}

impl Drop for Fast {
    fn drop(&mut self) {
        self.host.apply();
    }
}

use processor::{Control, FAST, read, write};

/// MXCSR, the control register of SSE and AVX and so of all arithmetic on `f64`.
#[cfg(target_arch = "x86_64")]
mod processor {
    use std::arch::asm;

    pub type Control = u32;

    /// Round to nearest with all traps masked (0x1f80); denormal results (0x8000) and operands (0x40) are zero.
    pub const FAST: Control = 0x1f80 | 0x8040;

    pub fn read() -> Control {
        let mut control: Control = 0;
        // SAFETY: the instruction writes the four bytes of `control` and changes nothing else.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags)) };
        control
    }

    pub fn write(control: Control) {
        // SAFETY: the instruction faults for reserved bits only; the value comes from `read`, or is `FAST`, whose bits
        // all 64-bit processors know. Rust asks a block to leave the control bits as it found them, which this one
        // breaks on purpose: nothing but the assumptions in the documentation of this crate makes up for it.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack)) };
    }
}

/// FPCR, the control register of scalar and vector arithmetic.
#[cfg(target_arch = "aarch64")]
mod processor {
    use std::arch::asm;

    pub type Control = u64;

    /// Round to nearest without traps (0); denormal operands and results are zero (bit 24).
    pub const FAST: Control = 1 << 24;

    pub fn read() -> Control {
        let control: Control;
        // SAFETY: each program may read the register.
        unsafe { asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack, preserves_flags)) };
        control
    }

    pub fn write(control: Control) {
        // SAFETY: no value faults, and bits that the processor lacks are ignored. Rust asks a block to leave the
        // register as it found it, which this one breaks on purpose: nothing but the assumptions in the documentation
        // of this crate makes up for it.
        unsafe { asm!("msr fpcr, {}", in(reg) control, options(nostack, preserves_flags)) };
    }
}

/// Other processors keep the modes of the host.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod processor {
    pub type Control = ();
    pub const FAST: Control = ();
    pub fn read() -> Control {}
    pub fn write((): Control) {}
}

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(all(test, any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use std::hint::black_box;
    use std::panic;

    use super::*;

    /// Round upward, keep denormal numbers.
    #[cfg(target_arch = "x86_64")]
    const UPWARD: Control = 0x1f80 | 0x4000;
    #[cfg(target_arch = "aarch64")]
    const UPWARD: Control = 1 << 22;

    /// Return the modes without the exception flags.
    fn modes() -> Control {
        read() & !0x3f
    }

    fn third() -> f64 {
        black_box(1.0) / black_box(3.0)
    }

    #[test]
    fn inside_denormal_numbers_are_zero_and_rounding_is_to_nearest_and_after_it_is_the_hosts() {
        let (default, nearest) = (Modes::of_thread(), third());
        Modes(UPWARD).apply();
        let denormal = black_box(f64::MIN_POSITIVE) / black_box(2.0);
        let outside = (third(), denormal);
        let inside = {
            let _fast = Fast::enter();
            (third(), black_box(f64::MIN_POSITIVE) / black_box(2.0), black_box(denormal) * black_box(2.0))
        };
        let after = modes();
        default.apply();
        assert!(outside.0 > nearest && outside.1 > 0.0, "the host's modes had no effect: {outside:?}");
        assert_eq!(inside, (nearest, 0.0, 0.0));
        assert_eq!(after, UPWARD);
    }

    #[test]
    fn after_a_panic_the_modes_are_the_hosts_too() {
        let default = Modes::of_thread();
        Modes(UPWARD).apply();
        let result = panic::catch_unwind(|| {
            let _fast = Fast::enter();
            panic!("on purpose");
        });
        let after = modes();
        default.apply();
        assert!(result.is_err() && after == UPWARD, "{after:#x}");
    }
}
