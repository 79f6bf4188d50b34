//! Camera frames: PGM and PNG, whose first row is the top one.

use super::{Expect, HEIGHT, Specimen, WIDTH, refused, scene};

pub(super) fn all() -> Vec<Specimen> {
    let wide: Vec<u16> = top_first().iter().map(|&v| v as u16).collect();
    let narrow: Vec<u8> = top_first().iter().map(|&v| (v / 32.0) as u8).collect();
    let bytes: Vec<u8> = wide.iter().flat_map(|v| v.to_be_bytes()).collect();
    let text: String = wide.iter().map(|v| format!("{v} ")).collect();
    let small = |v: f64| f32::from((v / 32.0) as u8);
    let read_wide = || Expect::Pixels(0, scene().iter().map(|&v| v as f32).collect());
    let read_narrow = || Expect::Pixels(0, scene().iter().map(|&v| small(v)).collect());
    let pgm = |magic: &str, white: u32, body: &[u8]| {
        [format!("{magic}\n# a comment\n{WIDTH} {HEIGHT}\n{white}\n").as_bytes(), body].concat()
    };
    let gray = |depth, data: &[u8]| png(png::ColorType::Grayscale, depth, data);
    let color = png(png::ColorType::Rgb, png::BitDepth::Eight, &vec![9; WIDTH * HEIGHT * 3]);
    let short = gray(png::BitDepth::Sixteen, &bytes);
    vec![
        Specimen { name: "frame16.pgm", bytes: pgm("P5", 65535, &bytes), expect: read_wide() },
        Specimen { name: "frame8.pgm", bytes: pgm("P5", 255, &narrow), expect: read_narrow() },
        Specimen { name: "frame_text.pgm", bytes: pgm("P2", 65535, text.as_bytes()), expect: read_wide() },
        Specimen { name: "frame16.png", bytes: gray(png::BitDepth::Sixteen, &bytes), expect: read_wide() },
        Specimen { name: "frame8.png", bytes: gray(png::BitDepth::Eight, &narrow), expect: read_narrow() },
        refused("color.png", "convert it to grayscale", color),
        refused("short.png", "PNG:", short[..short.len() / 2].to_vec()),
        refused("short.pgm", "truncated", pgm("P5", 65535, &bytes[..100])),
        refused("claim.pgm", "truncated", b"P5 4000000000 4000000000 65535\n".to_vec()),
        refused("no_numbers.pgm", "three numbers", b"P5 a b c\n".to_vec()),
        refused("too_white.pgm", "values up to 70000", b"P5 2 2 70000\n".to_vec()),
    ]
}

fn top_first() -> Vec<f64> {
    scene().chunks(WIDTH).rev().flatten().copied().collect()
}

fn png(color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().expect("writing to memory");
    writer.write_image_data(data).expect("writing to memory");
    writer.finish().expect("writing to memory");
    file
}
