// Segments a FITS file without the command line, measures its sources and writes a map.
//
//     cargo run --example segment_file -- image.fits labels.fits
use skyfront::catalogue::{Catalogue, Request};
use skyfront::input::Input;
use skyfront::pipeline::{Drive, segment};
use skyfront::read;
use skyfront::write::fits::Writer;
use skyfront_core::config::Config;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let (Some(image), Some(map)) = (words.next(), words.next()) else {
        return Err("name an image and a map to be written".into());
    };
    let mut config = Config::NOISE_AWARE;
    config.outline.threshold = 0.8;
    let input = Input::alone(&image, read::image(Path::new(&image), None)?);
    let (pixels, width, height) =
        (&input.detected.image.pixels, input.detected.image.width, input.detected.image.height);
    let run = segment(&config, pixels, width, height, &mut Drive::default())?;
    let catalogue = Catalogue::of(&input, &run, &Request::default());
    for row in &catalogue.rows {
        println!("{} {:.2} {:.2} {:.4e}", row.source.label, row.shape.x + 1.0, row.shape.y + 1.0, row.flux.value);
    }
    let mut writer = Writer::create(Path::new(&map))?;
    writer.image((width, height), &[], |y, row: &mut [i32]| {
        row.iter_mut().zip(&run.labels[y * width..]).for_each(|(out, &label)| *out = label as i32);
    })?;
    writer.finish()?;
    Ok(())
}
