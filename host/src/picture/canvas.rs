//! A picture in memory: pixels, text, PNG.

use super::Colour;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, ascii};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Baseline, Text};
use std::io::{self, Write};

/// An RGB picture, row-major, its top row first.
///
/// ```
/// use skyfront::picture::{Canvas, MARK};
///
/// let mut canvas = Canvas::new(64, 16);
/// canvas.set(3, 2, MARK);
/// assert_eq!(canvas.rgb()[3 * (2 * 64 + 3)..][..3], MARK);
/// let mut png = Vec::new();
/// canvas.write_png(&mut png)?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Canvas {
    /// A black picture.
    pub fn new(width: usize, height: usize) -> Self {
        Canvas { width, height, rgb: vec![0; 3 * width * height] }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Its pixels, three bytes each.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Sets a pixel; nothing happens outside the picture.
    pub fn set(&mut self, x: usize, y: usize, colour: Colour) {
        if x < self.width && y < self.height {
            let at = 3 * (y * self.width + x);
            self.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }

    /// Writes a line of text with its top left corner at (x, y), on a dark ground that keeps it
    /// readable on any picture.
    pub fn text(&mut self, x: usize, y: usize, text: &str, size: TextSize, colour: Colour) {
        let colour = Rgb888::new(colour[0], colour[1], colour[2]);
        let mut style = MonoTextStyle::new(size.font(), colour);
        style.background_color = Some(Rgb888::BLACK);
        let at = Point::new(x as i32, y as i32);
        let drawn = Text::with_baseline(text, at, style, Baseline::Top).draw(self);
        let Ok(_) = drawn;
    }

    /// Writes the picture as PNG; the same picture gives the same bytes.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_png(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(())
    }
}

/// Sizes of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextSize {
    /// For numbers beside sources.
    Small,
    /// For captions.
    Large,
}

impl TextSize {
    fn font(self) -> &'static MonoFont<'static> {
        match self {
            TextSize::Small => &ascii::FONT_8X13_BOLD,
            TextSize::Large => &ascii::FONT_10X20,
        }
    }

    /// Width of a character and height of a line, in pixels.
    pub fn cell(self) -> (usize, usize) {
        let size = self.font().character_size;
        (size.width as usize, size.height as usize)
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.width as u32, self.height as u32)
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Self::Error> {
        for Pixel(at, colour) in pixels {
            if let (Ok(x), Ok(y)) = (usize::try_from(at.x), usize::try_from(at.y)) {
                self.set(x, y, [colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}
