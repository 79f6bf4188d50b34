//! Places that are to be measured, from a table as text.

use std::fs;
use std::path::Path;

/// Names of columns, those of SExtractor beside ours, whatever the size of their letters.
const X: [&str; 2] = ["x", "x_image"];
const Y: [&str; 2] = ["y", "y_image"];
const RA: [&str; 2] = ["ra", "alpha_j2000"];
const DEC: [&str; 2] = ["dec", "delta_j2000"];
const LABEL: [&str; 3] = ["label", "number", "id"];

/// Places, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Positions {
    /// The places.
    pub places: Vec<At>,
    /// The label of each.
    pub labels: Vec<u32>,
}

/// A place in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// By pixels that count from 1.
    Pixel(f64, f64),
    /// By right ascension and declination in degrees, in the image's frame.
    Sky(f64, f64),
}

impl Positions {
    /// Reads a table of comma-separated values with a line of names, `x` and `y` or `ra` and `dec`
    /// among them; lines that begin with `#` are left out.
    ///
    /// # Errors
    /// What is wrong with the file, in words.
    pub fn read(path: &Path) -> Result<Positions, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Positions::parse(&text).map_err(|reason| format!("{}: {reason}", path.display()))
    }

    fn parse(text: &str) -> Result<Positions, String> {
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
        let (_, names) = lines.next().ok_or("no line of names")?;
        let names: Vec<String> = names.split(',').map(|name| name.trim().to_ascii_lowercase()).collect();
        let column = |of: &[&str]| names.iter().position(|name| of.contains(&name.as_str()));
        let (first, second, place): (_, _, fn(f64, f64) -> At) = match (column(&X), column(&Y)) {
            (Some(x), Some(y)) => (x, y, At::Pixel),
            _ => match (column(&RA), column(&DEC)) {
                (Some(ra), Some(dec)) => (ra, dec, At::Sky),
                _ => return Err("neither columns x and y nor ra and dec".to_owned()),
            },
        };
        let label = column(&LABEL);
        let mut found = Positions { places: Vec::new(), labels: Vec::new() };
        for (line, cells) in lines {
            let cells: Vec<&str> = cells.split(',').map(str::trim).collect();
            let cell = |column: usize| cells.get(column).copied().unwrap_or_default();
            let number = |column: usize| {
                let value = cell(column).parse().ok().filter(|value: &f64| value.is_finite());
                value.ok_or(format!("line {line}: {:?} is not a number", cell(column)))
            };
            found.places.push(place(number(first)?, number(second)?));
            let own = label.and_then(|column| cell(column).parse().ok());
            found.labels.push(own.unwrap_or(found.places.len() as u32));
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_by_pixel_or_by_sky() {
        let pixels = Positions::parse("# a comment\nNUMBER,X_IMAGE,y\n7,1.5,2\n\n9, 3 ,4\n").expect("places");
        assert_eq!(pixels.places, [At::Pixel(1.5, 2.0), At::Pixel(3.0, 4.0)]);
        assert_eq!(pixels.labels, [7, 9]);
        let sky = Positions::parse("dec,ra\n-5,10\n").expect("places");
        assert_eq!((sky.places, sky.labels), (vec![At::Sky(10.0, -5.0)], vec![1]));
    }

    #[test]
    fn what_is_no_place_is_named() {
        for (text, words) in [("", "names"), ("a,b\n1,2", "neither"), ("x,y\n1", "line 2: \"\""), ("x,y\nnan,1", "nan")]
        {
            assert!(Positions::parse(text).is_err_and(|reason| reason.contains(words)), "{text}");
        }
    }
}
