//! Scores of a segmentation against the truth, after Haigh et al. 2021 (A&A 645, A107), and
//! panoptic quality.

use std::collections::BTreeMap;

/// The measures of one label map.
///
/// ```
/// use skyfront::score::score;
///
/// let (truth, image) = ([1, 1, 0, 0, 2, 2], [5.0, 9.0, 0.0, 0.0, 7.0, 4.0]);
/// let found = score(&truth, &[1, 1, 0, 0, 0, 0], &image);
/// assert_eq!((found.objects, found.matched, found.completeness, found.purity), (2, 1, 0.5, 1.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Objects of the truth.
    pub objects: usize,
    /// Segments.
    pub segments: usize,
    /// Matched pairs.
    pub matched: usize,
    /// Matched part of the objects.
    pub completeness: f64,
    /// Matched part of the segments.
    pub purity: f64,
    /// Harmonic mean of the two.
    pub f_score: f64,
    /// Area that segments miss of their objects.
    pub under_merging: f64,
    /// Area that the objects' segments have beyond them.
    pub over_merging: f64,
    /// `cbrt((1 - OM) (1 - UM) F)`.
    pub combined: f64,
    /// Mean intersection over union of the matched pairs.
    pub mean_iou: f64,
    /// Panoptic quality.
    pub panoptic: f64,
}

impl Score {
    /// The measures by their names in the paper and in its program.
    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "n_truth": self.objects,
            "n_seg": self.segments,
            "tp": self.matched,
            "fp": self.segments - self.matched,
            "fn": self.objects - self.matched,
            "completeness": self.completeness,
            "purity": self.purity,
            "f_score": self.f_score,
            "um": self.under_merging,
            "om": self.over_merging,
            "area_score": 1.0 - self.under_merging.hypot(self.over_merging),
            "combined": self.combined,
            "mean_iou": self.mean_iou,
            "pq": self.panoptic,
        })
    }
}

/// Labels above 0 as 1 to n in increasing order; others 0.
fn compact(map: &[i64]) -> (Vec<usize>, usize) {
    let mut ids: BTreeMap<i64, usize> = map.iter().filter(|&&label| label > 0).map(|&label| (label, 0)).collect();
    for (number, id) in (1..).zip(ids.values_mut()) {
        *id = number;
    }
    (map.iter().map(|label| ids.get(label).copied().unwrap_or(0)).collect(), ids.len())
}

/// Sum over the first labels of `(|b| - |a & b|) |a & b| / |b|` for the `b` that covers most of `a`.
fn merging(overlaps: &BTreeMap<(usize, usize), f64>, areas: &[f64], swap: bool) -> f64 {
    let mut most: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for (&(object, segment), &count) in overlaps {
        let (from, to) = if swap { (object, segment) } else { (segment, object) };
        let best = most.entry(from).or_insert((0.0, usize::MAX));
        if count > best.0 || (count == best.0 && to < best.1) {
            *best = (count, to);
        }
    }
    most.values().map(|&(count, to)| (areas[to] - count) * count / areas[to]).sum()
}

fn ratio(part: usize, whole: usize) -> f64 {
    part as f64 / whole as f64
}

/// Scores `map` against `truth`, both with labels above 0; an object is found by the segment
/// over its brightest pixel in `image`, the first of equal ones.
pub fn score(truth: &[i64], map: &[i64], image: &[f32]) -> Score {
    let ((truth, objects), (map, segments)) = (compact(truth), compact(map));
    let mut overlaps = BTreeMap::new();
    let (mut object_area, mut segment_area) = (vec![0.0; objects + 1], vec![0.0; segments + 1]);
    let mut peaks: Vec<Option<usize>> = vec![None; objects + 1];
    for (at, (&object, &segment)) in truth.iter().zip(&map).enumerate() {
        *overlaps.entry((object, segment)).or_insert(0.0) += 1.0;
        object_area[object] += 1.0;
        segment_area[segment] += 1.0;
        if peaks[object].is_none_or(|peak| image[at] > image[peak]) {
            peaks[object] = Some(at);
        }
    }
    let pixels = truth.len() as f64;
    let under_merging = merging(&overlaps, &object_area, false) / pixels;
    let over_merging = merging(&overlaps, &segment_area, true) / pixels;
    let mut finder: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (object, &peak) in peaks.iter().enumerate().skip(1) {
        let Some(peak) = peak.filter(|&peak| map[peak] > 0) else { continue };
        let known = finder.entry(map[peak]).or_insert((object, peak));
        if image[peak] > image[known.1] {
            *known = (object, peak);
        }
    }
    let iou = |object: usize, segment: usize| {
        let both: f64 = overlaps.get(&(object, segment)).copied().unwrap_or(0.0);
        both / (object_area[object] + segment_area[segment] - both)
    };
    let matched = finder.len();
    let completeness = if objects > 0 { ratio(matched, objects) } else { 1.0 };
    let nothing = if objects == 0 { 1.0 } else { 0.0 };
    let purity = if segments > 0 { ratio(matched, segments) } else { nothing };
    let total = completeness + purity;
    let f_score = if total > 0.0 { 2.0 * completeness * purity / total } else { 0.0 };
    let pairs: f64 = finder.iter().map(|(&segment, &(object, _))| iou(object, segment)).sum();
    let good: Vec<f64> = overlaps
        .keys()
        .filter(|(object, segment)| *object > 0 && *segment > 0)
        .map(|&(object, segment)| iou(object, segment))
        .filter(|&iou| iou > 0.5)
        .collect();
    let either = 0.5 * (objects + segments) as f64;
    Score {
        objects,
        segments,
        matched,
        completeness,
        purity,
        f_score,
        under_merging,
        over_merging,
        combined: ((1.0 - over_merging) * (1.0 - under_merging) * f_score).cbrt(),
        mean_iou: if matched > 0 { pairs / matched as f64 } else { 0.0 },
        panoptic: if either > 0.0 { good.iter().sum::<f64>() / either } else { 1.0 },
    }
}
