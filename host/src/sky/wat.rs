//! Corrections in the projection plane as IRAF writes them, for TNX and ZPX: surfaces in the pieces of
//! text `WATi_nnn` (https://fits.gsfc.nasa.gov/registry/tnx.html and zpxwcs.html).

use super::keys::Keys;

/// No polynomial in use has more terms along an axis.
const MOST_TERMS: f64 = 40.0;
/// Parameters of ZPN that ZPX can name.
const PARAMETERS: usize = 10;

/// What is added to the place along each axis of the plane, degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Wat {
    longitude: Option<Surface>,
    latitude: Option<Surface>,
}

/// A sum of products of two polynomials.
#[derive(Clone, Debug, PartialEq)]
struct Surface {
    basis: Basis,
    /// The middle and half of the width of each variable's range.
    ranges: [(f64, f64); 2],
    /// Number of polynomials of each variable.
    orders: [usize; 2],
    /// Order of x, order of y, coefficient.
    terms: Vec<(usize, usize, f64)>,
}

/// The polynomials of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Basis {
    Chebyshev,
    Legendre,
    /// Powers of the variable itself.
    Powers,
}

impl Wat {
    /// The surfaces of a header whose longitude and latitude axes have these numbers; an axis without
    /// one is not corrected.
    ///
    /// # Errors
    /// A surface that cannot be read, in words; the latitude as the first axis, for which programs give
    /// the surfaces their variables in one order or the other.
    pub fn of(keys: &Keys, axes: [usize; 2]) -> Result<Wat, String> {
        if axes != [1, 2] {
            return Err("surfaces of TNX or ZPX with the latitude as the first axis".to_owned());
        }
        let surface = |axis: usize, name: &str| {
            let text = keys.pieces(&format!("WAT{axis}_"));
            let numbers = value(&text, name).map(str::to_owned);
            let read = |numbers: String| Surface::of(&numbers).map_err(|why| format!("{name} of WAT{axis}: {why}"));
            numbers.map(read).transpose()
        };
        Ok(Wat { longitude: surface(axes[0], "lngcor")?, latitude: surface(axes[1], "latcor")? })
    }

    /// The corrected place in the plane.
    pub fn apply(&self, [xi, eta]: [f64; 2]) -> [f64; 2] {
        let at = |surface: &Option<Surface>| surface.as_ref().map_or(0.0, |surface| surface.at([xi, eta]));
        [xi + at(&self.longitude), eta + at(&self.latitude)]
    }
}

/// The parameters of ZPN that the text of the latitude axis names, by their number; the first is 1 by
/// default.
///
/// # Errors
/// A parameter that is no number.
pub fn parameters(keys: &Keys, latitude: usize) -> Result<Vec<(usize, f64)>, String> {
    let text = keys.pieces(&format!("WAT{latitude}_"));
    let mut found = Vec::new();
    for m in 0..PARAMETERS {
        let name = format!("projp{m}");
        match value(&text, &name).map(|text| (text, crate::read::header::real(text))) {
            Some((_, Some(number))) => found.push((m, number)),
            Some((text, None)) => return Err(format!("{name} = {text} of WAT{latitude}")),
            None => found.extend((m == 1).then_some((1, 1.0))),
        }
    }
    Ok(found)
}

/// What stands behind a name and an equals sign: a word, or what is between quotes.
fn value<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let behind = |(at, _): (usize, &str)| {
        let begins = text[..at].chars().next_back().is_none_or(char::is_whitespace);
        let rest = text[at + name.len()..].trim_start().strip_prefix('=')?.trim_start();
        let value = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split('"').next(),
            None => rest.split_whitespace().next(),
        };
        value.filter(|_| begins)
    };
    text.match_indices(name).find_map(behind)
}

impl Surface {
    /// From the numbers: kind, orders of x and y, kind of mixed terms, ranges of x and y, coefficients.
    fn of(text: &str) -> Result<Surface, String> {
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(crate::read::header::real).collect();
        let numbers = numbers.ok_or("it is not made of numbers")?;
        let Some((head, coefficients)) = numbers.split_first_chunk::<8>() else {
            return Err("it has fewer than 8 numbers".to_owned());
        };
        let [kind, x_order, y_order, mixed, x_min, x_max, y_min, y_max] = *head;
        let basis = match kind {
            1.0 => Basis::Chebyshev,
            2.0 => Basis::Legendre,
            3.0 => Basis::Powers,
            _ => return Err(format!("kind {kind} of surface")),
        };
        let sound = |order: f64| order.fract() == 0.0 && (1.0..=MOST_TERMS).contains(&order);
        if !(sound(x_order) && sound(y_order) && x_min < x_max && y_min < y_max) {
            return Err("orders or ranges out of bounds".to_owned());
        }
        let orders = [x_order as usize, y_order as usize];
        let most = orders[0].max(orders[1]);
        let has: fn(usize, usize, usize) -> bool = match mixed {
            0.0 => |m, n, _| m == 0 || n == 0,
            1.0 => |_, _, _| true,
            2.0 => |m, n, most| m + n < most,
            _ => return Err(format!("mixed terms of kind {mixed}")),
        };
        let pairs = (0..orders[1]).flat_map(|n| (0..orders[0]).map(move |m| (m, n)));
        let pairs: Vec<(usize, usize)> = pairs.filter(|&(m, n)| has(m, n, most)).collect();
        if pairs.len() != coefficients.len() {
            return Err(format!("{} coefficients, not {}", coefficients.len(), pairs.len()));
        }
        let ranges = [(x_min, x_max), (y_min, y_max)].map(|(low, high)| (0.5 * (low + high), 0.5 * (high - low)));
        let terms = pairs.into_iter().zip(coefficients).map(|((m, n), &c)| (m, n, c)).collect();
        Ok(Surface { basis, ranges, orders, terms })
    }

    fn at(&self, place: [f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| {
            let (middle, half) = self.ranges[axis];
            match self.basis {
                Basis::Powers => self.basis.values(place[axis], self.orders[axis]),
                _ => self.basis.values((place[axis] - middle) / half, self.orders[axis]),
            }
        });
        self.terms.iter().map(|&(m, n, c)| c * x[m] * y[n]).sum()
    }
}

impl Basis {
    /// The first polynomials at a place.
    fn values(self, t: f64, count: usize) -> Vec<f64> {
        let mut values = vec![1.0, t];
        for n in 2..count {
            let (last, before, k) = (values[n - 1], values[n - 2], n as f64);
            values.push(match self {
                Basis::Chebyshev => 2.0 * t * last - before,
                Basis::Legendre => ((2.0 * k - 1.0) * t * last - (k - 1.0) * before) / k,
                Basis::Powers => t * last,
            });
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_words_or_stand_between_quotes() {
        let text = "wtype=tnx axtype=ra mylngcor=1 lngcor = \"3. 4. 4.\" projp1=1.5 projp3= 220";
        assert_eq!(value(text, "lngcor"), Some("3. 4. 4."));
        assert_eq!(
            (value(text, "projp1"), value(text, "projp3"), value(text, "projp2")),
            (Some("1.5"), Some("220"), None)
        );
    }

    #[test]
    fn surfaces_that_cannot_be_meant_are_refused() {
        for (text, word) in [
            ("3 2 2 1 -1 1 -1 1 1 2 3", "3 coefficients, not 4"),
            ("3 2 2 2 -1 1 -1 1 1 2 3 4", "4 coefficients, not 3"),
            ("4 1 1 1 -1 1 -1 1 1", "kind 4"),
            ("3 1 1 7 -1 1 -1 1 1", "kind 7"),
            ("3 1 1 1 1 -1 -1 1 1", "bounds"),
            ("3 0 1 1 -1 1 -1 1", "bounds"),
            ("3 1 1", "fewer"),
            ("3 1 1 1 -1 1 -1 1 much", "not made of numbers"),
        ] {
            let why = Surface::of(text).expect_err(text);
            assert!(why.contains(word), "{text}: {why}");
        }
    }
}
