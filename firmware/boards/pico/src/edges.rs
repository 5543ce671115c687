//! Pins whose edges an interrupt watches: encoders and the echoes of the sonars.

use core::cell::RefCell;

use critical_section::Mutex;
use embedded_hal::digital::InputPin;
use rp2040_hal::Timer;
use rp2040_hal::gpio::{DynPinId, FunctionSioInput, Interrupt, Pin, PullDown, PullUp};
use rp2040_hal::pac::{self, interrupt};
use sr04_firmware::board::Side;

/// The pin of an encoder.
pub type Encoder = Pin<DynPinId, FunctionSioInput, PullUp>;

/// The pin of an echo.
pub type EchoPin = Pin<DynPinId, FunctionSioInput, PullDown>;

/// What the interrupt knows.
struct Watched {
    timer: Timer,
    encoders: [Encoder; 2],
    edges: [u16; 2],
    echoes: [EchoPin; 2],
    began_us: [u32; 2],
    pulse_us: [Option<u32>; 2],
}

static WATCHED: Mutex<RefCell<Option<Watched>>> = Mutex::new(RefCell::new(None));

/// Watches the pins, left and right, from now on.
pub fn start(timer: Timer, encoders: [Encoder; 2], echoes: [EchoPin; 2]) {
    for pin in &encoders {
        pin.set_interrupt_enabled(Interrupt::EdgeHigh, true);
        pin.set_interrupt_enabled(Interrupt::EdgeLow, true);
    }
    for pin in &echoes {
        pin.set_interrupt_enabled(Interrupt::EdgeHigh, true);
        pin.set_interrupt_enabled(Interrupt::EdgeLow, true);
    }
    critical_section::with(|token| {
        WATCHED.borrow_ref_mut(token).replace(Watched {
            timer,
            encoders,
            edges: [0; 2],
            echoes,
            began_us: [0; 2],
            pulse_us: [None; 2],
        });
    });
    // SAFETY: everything that the interrupt uses is in `WATCHED` now, and it takes its lock.
    unsafe { pac::NVIC::unmask(pac::Interrupt::IO_IRQ_BANK0) };
}

fn with<R>(read: impl FnOnce(&mut Watched) -> R) -> Option<R> {
    critical_section::with(|token| WATCHED.borrow_ref_mut(token).as_mut().map(read))
}

/// Edges of an encoder since the start, modulo 65,536.
pub fn count(side: Side) -> u16 {
    with(|watched| watched.edges[side as usize]).unwrap_or_default()
}

/// Forgets the latest pulse of an echo.
pub fn expect_echo(side: Side) {
    with(|watched| watched.pulse_us[side as usize] = None);
}

/// Length of the pulse since [`expect_echo`] in microseconds; `None` if none has ended.
pub fn echo_us(side: Side) -> Option<u32> {
    with(|watched| watched.pulse_us[side as usize]).flatten()
}

#[interrupt]
fn IO_IRQ_BANK0() {
    with(|watched| {
        let now_us = watched.timer.get_counter_low();
        for (pin, edges) in watched.encoders.iter_mut().zip(&mut watched.edges) {
            for edge in [Interrupt::EdgeHigh, Interrupt::EdgeLow] {
                if pin.interrupt_status(edge) {
                    pin.clear_interrupt(edge);
                    *edges = edges.wrapping_add(1);
                }
            }
        }
        for (side, pin) in watched.echoes.iter_mut().enumerate() {
            let rises = pin.interrupt_status(Interrupt::EdgeHigh);
            let falls = pin.interrupt_status(Interrupt::EdgeLow);
            pin.clear_interrupt(Interrupt::EdgeHigh);
            pin.clear_interrupt(Interrupt::EdgeLow);
            if falls && matches!(pin.is_low(), Ok(true)) {
                watched.pulse_us[side] = Some(now_us.wrapping_sub(watched.began_us[side]));
            } else if rises {
                watched.began_us[side] = now_us;
            }
        }
    });
}
