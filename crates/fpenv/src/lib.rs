//! The floating-point modes of a thread.
//!
//! The host's rounding, flush-to-zero and trap modes must not change a result, and numbers too small for full precision
//! (below 2.2e-308) must not slow one down: where a flow comes to rest, all of them become so small. [`Fast`] rounds to
//! nearest, takes such numbers for zero, masks all traps, and leaves the host's modes as they were. A thread begins in the
//! modes of the thread that started it on Linux, and in default ones elsewhere: [`Modes::apply`] brings them along.
//!
//! Rust itself calculates at compile time as if denormal numbers were kept. No result here depends on that.

/// Rounding, denormal numbers and traps of a thread, with the flags of what happened so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modes(Control);

impl Modes {
    /// Those of this thread.
    pub fn of_thread() -> Self {
        Modes(read())
    }

    /// Make them those of this thread.
    pub fn apply(self) {
        write(self.0);
    }
}

/// To nearest and without denormal numbers, in force until this is dropped; then the host's modes are back.
pub struct Fast {
    host: Modes,
}

impl Fast {
    /// Leave the host's modes.
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

/// MXCSR: what SSE and AVX obey, and with them all arithmetic on `f64`.
#[cfg(target_arch = "x86_64")]
mod processor {
    use std::arch::asm;

    pub type Control = u32;

    /// To nearest and all traps masked (0x1f80), results (0x8000) and operands (0x40) that are denormal are zero.
    pub const FAST: Control = 0x1f80 | 0x8040;

    pub fn read() -> Control {
        let mut control: Control = 0;
        // SAFETY: the instruction writes the four bytes that it is given.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags)) };
        control
    }

    pub fn write(control: Control) {
        // SAFETY: the value comes from `read` or is `FAST`, so no reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack, preserves_flags, readonly)) };
    }
}

/// FPCR: what scalar and vector arithmetic obey.
#[cfg(target_arch = "aarch64")]
mod processor {
    use std::arch::asm;

    pub type Control = u64;

    /// To nearest and no trap (0), operands and results that are denormal are zero (bit 24).
    pub const FAST: Control = 1 << 24;

    pub fn read() -> Control {
        let control: Control;
        // SAFETY: the register can be read by every program.
        unsafe { asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack, preserves_flags)) };
        control
    }

    pub fn write(control: Control) {
        // SAFETY: the value comes from `read` or is `FAST`; bits that the processor has not got read as zero.
        unsafe { asm!("msr fpcr, {}", in(reg) control, options(nostack, preserves_flags)) };
    }
}

/// Other processors are left in the modes of the host.
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

    /// Upward, denormal numbers kept.
    #[cfg(target_arch = "x86_64")]
    const UPWARD: Control = 0x1f80 | 0x4000;
    #[cfg(target_arch = "aarch64")]
    const UPWARD: Control = 1 << 22;

    /// Without the flags of what happened, which are no modes.
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
