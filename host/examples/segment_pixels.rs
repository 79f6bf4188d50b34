// Segments pixels in memory and compares them with their truth, without a file.
use skyfront::pipeline::{Drive, segment};
use skyfront::score::score;
use skyfront::truth::{labels, simulated};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::simulate::Kind;

fn main() -> Result<(), Error> {
    const SIDE: usize = 160;
    let (image, sky) = simulated(Kind::Bright, 5, SIDE, SIDE);
    let run = segment(&Config::NOISE_AWARE, &image.pixels, SIDE, SIDE, &mut Drive::default())?;
    let [truth, map] =
        [labels(&sky, SIDE, SIDE), run.labels].map(|labels| labels.into_iter().map(i64::from).collect::<Vec<i64>>());
    let score = score(&truth, &map, &image.pixels);
    println!("{} of {} objects found, {} sources", score.matched, score.objects, score.segments);
    let sky = run.sky.expect("the default measures it");
    println!("noise {:.2e}, of which the sky was made with {:.2e}", sky.noise[0], 8e-4);
    assert!(4 * score.matched > 3 * score.objects);
    Ok(())
}
