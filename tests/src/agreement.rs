//! One configuration of the paper in the f64 reference and in every arithmetic of the core.

use skyfront::crosscheck::{Comparison, compare, parameters};
use skyfront::machine::Native;
use skyfront::pipeline::{Drive, segment_in};
use skyfront::reference::{Stages, run};
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::profile::Profile;

/// The reference, and how far each arithmetic is from it; `None` where one cannot serve the configuration.
pub struct Agreement {
    /// The reference, with the paper's own `u0`.
    pub reference: Stages,
    /// f32, q24 and q11.
    pub core: [Option<Comparison>; 3],
}

impl Agreement {
    /// Runs a configuration without a band everywhere. An arithmetic that needs a band has it and is still measured
    /// against the reference without: what the band changes counts.
    pub fn of(config: &Config, pixels: &[f32], width: usize) -> Agreement {
        let wide: Vec<f64> = pixels.iter().map(|&pixel| pixel.into()).collect();
        let height = pixels.len() / width;
        let reference = run(&parameters(config), &wide, width, height).expect("the paper's parameters");
        let core = [
            beside::<F32<Native>>(config, pixels, width, &reference),
            beside::<Q24>(config, pixels, width, &reference),
            beside::<Q11>(config, pixels, width, &reference),
        ];
        Agreement { reference, core }
    }
}

fn beside<A: Arithmetic>(config: &Config, pixels: &[f32], width: usize, reference: &Stages) -> Option<Comparison> {
    let config = Config { band: A::NEEDS_BAND, ..*config };
    let mut drive = Drive { keep_stages: true, ..Drive::default() };
    let height = pixels.len() / width;
    match segment_in::<A>(&config, pixels, width, height, &mut drive) {
        Err(Error::Arithmetic { .. }) => None,
        run => {
            let unit = f64::from(Profile::new(&config, width, height).unit);
            Some(compare(pixels, &run.expect("a good image"), reference, unit))
        }
    }
}
