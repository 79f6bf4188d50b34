//! A rectangle of an image, by pixels that count from 1, both ends included (`[X0:X1,Y0:Y1]`, `*` for
//! all of an axis), and the plane of a cube that it lies in (`[X0:X1,Y0:Y1,K]`).

use super::Image;
use super::error::Fault;
use super::header::{Card, Header};

/// First and last column, first and last row; none for a whole axis. The plane, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Section {
    columns: Option<(usize, usize)>,
    rows: Option<(usize, usize)>,
    plane: Option<usize>,
}

impl Section {
    /// The section that a text names.
    pub(super) fn parse(text: &str) -> Option<Section> {
        let range = |text: &str| match text.trim() {
            "*" => Some(None),
            text => {
                let (first, last) = text.split_once(':')?;
                Some(Some((first.trim().parse().ok()?, last.trim().parse().ok()?)))
            }
        };
        let (columns, rest) = text.split_once(',')?;
        let (rows, plane) = rest.split_once(',').map_or((rest, None), |(rows, plane)| (rows, Some(plane)));
        let plane = plane.map(|plane| plane.trim().parse().ok()).map_or(Some(None), |plane| plane.map(Some))?;
        Some(Section { columns: range(columns)?, rows: range(rows)?, plane })
    }

    /// The plane of a cube.
    pub(super) fn plane(self) -> Option<usize> {
        self.plane
    }

    /// The section of an image; its coordinates stay true.
    pub(super) fn of(self, image: Image) -> Result<Image, Fault> {
        let (x0, x1) = self.columns.unwrap_or((1, image.width));
        let (y0, y1) = self.rows.unwrap_or((1, image.height));
        if !(1 <= x0 && x0 <= x1 && x1 <= image.width && 1 <= y0 && y0 <= y1 && y1 <= image.height) {
            let (width, height) = (image.width, image.height);
            return Err(Fault::Section(format!(
                "section [{x0}:{x1},{y0}:{y1}] is not within {width} x {height} pixels"
            )));
        }
        let rows = image.pixels.chunks_exact(image.width).take(y1).skip(y0 - 1);
        Ok(Image {
            width: x1 - x0 + 1,
            height: y1 - y0 + 1,
            pixels: rows.flat_map(|row| row[x0 - 1..x1].iter().copied()).collect(),
            header: moved(&image.header, [x0 - 1, y0 - 1]),
            ..image
        })
    }
}

/// A header whose reference pixels are so many columns and rows nearer to the first pixel, which on a
/// photographic plate is so many farther from its corner.
fn moved(header: &Header, by: [usize; 2]) -> Header {
    const MOVED: [(&str, f64, usize); 4] =
        [("CRPIX1", -1.0, 0), ("CRPIX2", -1.0, 1), ("CNPIX1", 1.0, 0), ("CNPIX2", 1.0, 1)];
    let card = |card: &Card| {
        let keyword = card.keyword();
        let names = |name: &str| keyword.strip_prefix(name).is_some_and(|letter| letter.len() < 2);
        let value = card.value().and_then(|text| super::header::real(&text));
        match MOVED.iter().find(|(name, ..)| names(name)).zip(value) {
            Some((&(_, sign, axis), value)) => {
                Card::new(&format!("{keyword:<8}= {:>20?}", value + sign * by[axis] as f64))
            }
            None => *card,
        }
    };
    Header::new(header.cards().iter().map(card).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let cards = ["CRPIX1  = 3.5 / middle", "CRPIX2A = 1", "CRVAL1  = 3.5", "CNPIX1  = 88"].map(Card::new).to_vec();
        Image {
            width: 4,
            height: 3,
            pixels: (0..12u8).map(f32::from).collect(),
            header: Header::new(cards),
            primary: Header::default(),
            hdu: 0,
            name: None,
            bitpix: -32,
            checksum: 0,
            warnings: Vec::new(),
        }
    }

    #[test]
    fn a_section_has_its_pixels_and_the_coordinates_of_the_whole() {
        let part = Section::parse("2:3, *").and_then(|section| section.of(image()).ok()).expect("a section");
        assert_eq!((part.width, part.height), (2, 3));
        assert_eq!(part.pixels, [1.0, 2.0, 5.0, 6.0, 9.0, 10.0]);
        let real = |keyword: &str| part.header.real(keyword);
        assert_eq!((real("CRPIX1"), real("CRPIX2A"), real("CRVAL1")), (Some(2.5), Some(1.0), Some(3.5)));
        assert_eq!(real("CNPIX1"), Some(89.0));
        let lower = Section::parse("1:4,3:3").and_then(|section| section.of(image()).ok()).expect("a row");
        assert_eq!((lower.pixels.as_slice(), lower.header.real("CRPIX2A")), (&[8.0, 9.0, 10.0, 11.0][..], Some(-1.0)));
    }

    #[test]
    fn what_is_no_section_of_the_image_is_refused() {
        for text in ["0:2,1:3", "2:1,1:3", "1:5,1:3", "1:4,1:4"] {
            let fault = Section::parse(text).expect("a section").of(image());
            assert!(fault.is_err_and(|fault| fault.to_string().contains("section [")), "{text}");
        }
        for text in ["SCI", "DQ,2", "1", "1:2", "a:b,1:2", "*,*,", "*,*,1:2", "*,*,1,1"] {
            assert_eq!(Section::parse(text), None, "{text}");
        }
    }
}
