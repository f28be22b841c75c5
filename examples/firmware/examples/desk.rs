//! What the emulated chip must print, computed on the desk: bits of the velocity every hundred samples, of the bias, and of the velocity
//! beside an encoder.

use proofmass_example_firmware::{Aided, Pipeline, SAMPLES, reading};

fn main() -> Result<(), proofmass_core::Error> {
    let mut pipeline = Pipeline::new()?;
    for sample in 0..SAMPLES {
        let (counts, temperature, stands) = reading(sample);
        let velocity = pipeline.step(counts, temperature, stands);
        if sample % 100 == 99 {
            println!("{sample} {:08x}", velocity.to_bits());
        }
    }
    println!("bias {:08x}", pipeline.bias().to_bits());
    let mut aided = Aided::new()?;
    for sample in 0..SAMPLES {
        if let Some(velocity) = aided.step(sample).filter(|_| sample % 100 == 98) {
            println!("aided {sample} {:08x}", velocity.to_bits());
        }
    }
    Ok(())
}
