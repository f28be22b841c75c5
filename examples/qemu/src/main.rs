//! The firmware example on an emulated Cortex-M4: prints the bits the desk prints, and instructions per sample.
//!
//! ```text
//! cd examples/qemu && cargo run --release
//! cargo run --release --target thumbv6m-none-eabi   # Cortex-M0, without a floating-point unit
//! ```
#![no_std]
#![no_main]

mod velocity;

use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use proofmass_core::{Compensation, FixedPoint, FixedRange};
use proofmass_example_firmware::{Aided, Pipeline, SAMPLES, SENSOR, reading};

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

/// Tenths of an instruction in one tick, at one nanosecond each: 25 MHz on the Cortex-M4, 16 MHz on the Cortex-M0.
const PER_TICK: u64 = if cfg!(armv6m) { 625 } else { 400 };

/// Instructions of a piece of work done for every sample.
fn measure(mut work: impl FnMut(u32)) -> u32 {
    let begin = SYST::get_current();
    for sample in 0..SAMPLES {
        work(sample);
    }
    begin.wrapping_sub(SYST::get_current()) & 0x00ff_ffff
}

fn per_sample(ticks: u32, idle: u32) -> u32 {
    let tenths = u64::from(ticks.saturating_sub(idle)) * PER_TICK;
    (tenths / u64::from(10 * SAMPLES)) as u32
}

#[entry]
fn main() -> ! {
    let Ok(mut pipeline) = Pipeline::new() else {
        panic!();
    };
    for sample in 0..SAMPLES {
        let (counts, temperature, stands) = reading(sample);
        let velocity = pipeline.step(counts, temperature, stands);
        if sample % 100 == 99 {
            hprintln!("{} {:08x}", sample, velocity.to_bits());
        }
    }
    hprintln!("bias {:08x}", pipeline.bias().to_bits());
    let Ok(mut aided) = Aided::new() else {
        panic!();
    };
    for sample in 0..SAMPLES {
        if let Some(velocity) = aided.step(sample).filter(|_| sample % 100 == 98) {
            hprintln!("aided {} {:08x}", sample, velocity.to_bits());
        }
    }

    let Some(mut peripherals) = Peripherals::take() else {
        panic!();
    };
    peripherals.SYST.set_clock_source(SystClkSource::Core);
    peripherals.SYST.set_reload(0x00ff_ffff);
    peripherals.SYST.clear_current();
    peripherals.SYST.enable_counter();
    let inputs: [[f32; 3]; 64] = core::array::from_fn(|i| reading(i as u32 * 40).0.map(f32::from));
    let counts: [[i32; 3]; 64] = core::array::from_fn(|i| reading(i as u32 * 40).0.map(i32::from));
    let at = |s: u32| black_box(s as usize & 63);
    let idle = measure(|s| {
        black_box(at(s));
    });
    let linear = measure(|s| {
        black_box(SENSOR.sensor().apply(black_box(inputs[at(s)])));
    });
    let thermal = measure(|s| {
        black_box(SENSOR.apply(black_box(inputs[at(s)]), black_box(30.0)));
    });
    let range = FixedRange {
        outputs: [[0, 65_535]; 3],
        temperature: [-40.0, 85.0],
    };
    let double = SENSOR.cast::<f64>();
    let plain = FixedPoint::new(&Compensation::from(*double.sensor()), range);
    let warm = FixedPoint::new(&double, range);
    let (Ok(plain), Ok(warm)) = (plain, warm) else {
        panic!();
    };
    let fixed = measure(|s| {
        black_box(plain.apply(black_box(counts[at(s)]), 0));
    });
    let fixed_thermal = measure(|s| {
        black_box(warm.apply(black_box(counts[at(s)]), black_box(30 * 256)));
    });
    let mut again = pipeline;
    let whole = measure(|s| {
        let (counts, temperature, stands) = reading(black_box(s));
        black_box(again.step(counts, temperature, stands));
    });
    for (name, ticks) in [
        ("linear, single precision", linear),
        ("temperature, single precision", thermal),
        ("linear, integers", fixed),
        ("temperature, integers", fixed_thermal),
        ("compensation, bias filter, Butterworth, velocity", whole),
    ] {
        hprintln!("instructions {}: {}", per_sample(ticks, idle), name);
    }
    let Ok(costs) = velocity::costs() else {
        panic!();
    };
    for (name, ticks) in costs {
        hprintln!("instructions {}: {}", per_sample(ticks, idle), name);
    }
    hprintln!(
        "instructions {}: bytes of state",
        core::mem::size_of::<Pipeline>()
    );
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
