//! Pictures inside the page: PNG as base64 text.

use crate::picture::{Canvas, Stretch, reduced};
use serde_json::{Value, json};
use std::io;

/// The longer side of the image in the page, at most.
const SIDE: usize = 2048;

/// A canvas as the address of an image; grey ones take a third of the room.
pub fn of_canvas(canvas: &Canvas) -> String {
    let grey = canvas.rgb().chunks_exact(3).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2]);
    if grey {
        let shades: Vec<u8> = canvas.rgb().iter().copied().step_by(3).collect();
        address(canvas.width(), canvas.height(), png::ColorType::Grayscale, &shades)
    } else {
        address(canvas.width(), canvas.height(), png::ColorType::Rgb, canvas.rgb())
    }
}

/// An image, its last row on top, in codes from which the page makes any stretch: asinh of the value
/// above a pivot, as 16 bits in red and green, 0 where it is undefined. Means of squares of pixels
/// where it is larger than the page needs.
pub fn preview(pixels: &[f32], width: usize, height: usize) -> Value {
    let step = width.max(height).div_ceil(SIDE).max(1);
    let (columns, rows) = (width.div_ceil(step), height.div_ceil(step));
    let means = reduced(pixels, width, height, step);
    let stretch = Stretch::of(pixels);
    let codes = Codes::of(&means, &stretch);
    let upright = means.chunks_exact(columns.max(1)).rev().flatten();
    let colours: Vec<u8> = upright
        .flat_map(|&mean| {
            let [high, low] = codes.code(mean).to_be_bytes();
            [high, low, 0]
        })
        .collect();
    json!({
        "image": address(columns, rows, png::ColorType::Rgb, &colours),
        "step": step,
        "pivot": codes.pivot,
        "scale": codes.scale,
        "low": codes.low,
        "high": codes.high,
        "black": stretch.black(),
        "white": stretch.white(),
    })
}

/// From values to codes of 16 bits, finest near the sky.
struct Codes {
    pivot: f64,
    scale: f64,
    /// The asinh of the least value.
    low: f64,
    /// The asinh of the greatest.
    high: f64,
}

impl Codes {
    fn of(values: &[f32], stretch: &Stretch) -> Codes {
        let (pivot, scale) = (stretch.black(), stretch.scale());
        let asinh = |value: f32| ((f64::from(value) - pivot) / scale).asinh();
        let all = values.iter().copied().filter(|value| value.is_finite()).map(asinh);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if low <= high { Codes { pivot, scale, low, high } } else { Codes { pivot, scale, low: 0.0, high: 1.0 } }
    }

    fn code(&self, value: f32) -> u16 {
        if !value.is_finite() {
            return 0;
        }
        let part = (((f64::from(value) - self.pivot) / self.scale).asinh() - self.low) / (self.high - self.low);
        // A flat image has one value.
        let part = if part.is_finite() { part } else { 0.0 };
        1 + (part * f64::from(u16::MAX - 1)).round() as u16
    }
}

/// A PNG as a `data:` address; an empty one, which shows nothing, where it cannot be made.
fn address(width: usize, height: usize, colours: png::ColorType, bytes: &[u8]) -> String {
    let mut file = Vec::new();
    match encode(&mut file, width, height, colours, bytes) {
        Ok(()) => format!("data:image/png;base64,{}", base64(&file)),
        Err(_) => "data:,".to_owned(),
    }
}

fn encode(out: &mut Vec<u8>, width: usize, height: usize, colours: png::ColorType, bytes: &[u8]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width as u32, height as u32);
    encoder.set_color(colours);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    Ok(writer.finish()?)
}

/// Base64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let word = three.iter().fold(0u32, |word, &byte| word << 8 | u32::from(byte)) << (8 * (3 - three.len()));
        for digit in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * digit)) as usize & 63];
            text.push(if digit > three.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_the_rfc() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in cases {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn codes_keep_values_to_a_thousandth_of_the_spread_of_the_sky_and_of_themselves() {
        let noise = |at: usize| 100.0 + ((at * 7919) % 1009) as f32 / 500.0;
        let values: Vec<f32> =
            (0..5000).map(|at| if at % 97 == 0 { 100.0 + (at * at) as f32 } else { noise(at) }).collect();
        let codes = Codes::of(&values, &Stretch::of(&values));
        let value = |code: u16| {
            let part = f64::from(code - 1) / f64::from(u16::MAX - 1);
            codes.pivot + codes.scale * (codes.low + part * (codes.high - codes.low)).sinh()
        };
        for &known in &values {
            let error = (value(codes.code(known)) - f64::from(known)).abs();
            assert!(error < 1e-3 * (1.0 + f64::from(known) - 100.0), "{known}: {error}");
        }
        assert_eq!(codes.code(f32::NAN), 0);
        assert!(values.iter().all(|&known| codes.code(known) > 0));
        let flat = Codes::of(&[5.0; 9], &Stretch::of(&[5.0; 9]));
        assert_eq!(flat.code(5.0), 1);
    }
}
