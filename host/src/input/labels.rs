//! A label map that exists, whose sources are to be measured.

/// Up to here every whole number has its own f32, in which maps are read.
const GREATEST: f32 = 16_777_216.0;

/// The labels of every pixel.
///
/// ```
/// use skyfront::input::LabelMap;
///
/// let map = LabelMap::of(&[0.0, 7.0, 0.0, 300.0]).expect("whole numbers");
/// assert_eq!((map.name(1), map.name(2)), (7, 300));
/// assert!(LabelMap::of(&[0.0, 1.5]).is_err_and(|at| at == 1));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LabelMap {
    /// Row-major, 0 = none, else 1 for the first of `names`.
    pub labels: Vec<u32>,
    /// The labels that occur in the map, in order.
    pub names: Vec<u32>,
}

impl LabelMap {
    /// The labels of a map; undefined pixels have none.
    ///
    /// # Errors
    /// The index of the first value that is no label.
    pub fn of(map: &[f32]) -> Result<LabelMap, usize> {
        let sound = |value: &f32| value.is_nan() || (value.fract() == 0.0 && (0.0..GREATEST).contains(value));
        if let Some(odd) = map.iter().position(|value| !sound(value)) {
            return Err(odd);
        }
        let mut names: Vec<u32> = Vec::new();
        // Neighbours in a row mostly have the same label.
        let mut last = 0;
        for label in map.iter().map(|&value| value as u32) {
            if label != last && label != 0 {
                names.push(label);
            }
            last = label;
        }
        names.sort_unstable();
        names.dedup();
        let place = |label: u32| names.binary_search(&label).map_or(0, |index| index as u32 + 1);
        let labels = map.iter().map(|&value| if value > 0.0 { place(value as u32) } else { 0 }).collect();
        Ok(LabelMap { labels, names })
    }

    /// The name of a label of [`Self::labels`].
    pub fn name(&self, label: u32) -> u32 {
        let index = (label as usize).checked_sub(1);
        index.and_then(|index| self.names.get(index)).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_gaps_become_a_row_and_keep_their_names() {
        let found = LabelMap::of(&[0.0, 7.0, 7.0, f32::NAN, 3.0, 900_000.0, 7.0]).expect("labels");
        assert_eq!(
            (found.labels.as_slice(), found.names.as_slice()),
            (&[0, 2, 2, 0, 1, 3, 2][..], &[3, 7, 900_000][..])
        );
        assert_eq!([0, 1, 3, 4].map(|label| found.name(label)), [0, 3, 900_000, 0]);
    }

    #[test]
    fn what_is_no_label_is_found() {
        for odd in [0.5, -1.0, GREATEST, f32::INFINITY] {
            assert_eq!(LabelMap::of(&[1.0, odd]), Err(1), "{odd}");
        }
    }
}
