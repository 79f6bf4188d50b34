//! Step 6: connected components of {u > 0}.

use super::{Connectivity, Parameters, Scheme};

/// Labels 1, 2, ... of the components of `mask` (rows of `width`) in raster order of their first pixel, and their
/// number. Components of fewer than `min_area` pixels are background; the others are numbered without a gap.
pub fn label(mask: &[bool], width: usize, connectivity: Connectivity, min_area: usize) -> (Vec<u32>, u32) {
    let mut labels = vec![0; mask.len()];
    let mut seen = vec![false; mask.len()];
    let mut count = 0;
    for first in 0..mask.len() {
        if !mask[first] || seen[first] {
            continue;
        }
        let component = component(mask, &mut seen, width, connectivity, first);
        if component.len() >= min_area {
            count += 1;
            for pixel in component {
                labels[pixel] = count;
            }
        }
    }
    (labels, count)
}

/// Whether no front from the border can have reached a node by T_max (ours). It starts two pixels inside, its speed is
/// 1 at most, and two pixels are the width of its profile.
pub fn is_beyond_reach(p: &Parameters, pixel: usize, width: usize, height: usize) -> bool {
    let starts_near = p.start_margin.is_some() || matches!(p.scheme, Scheme::ChanVese | Scheme::Multiphase);
    let depth = |at: usize, n: usize| at.min(n - 1 - at) as f64 - 1.5;
    !starts_near && depth(pixel % width, width).min(depth(pixel / width, height)) > p.t_max / p.dx + 2.0
}

/// Sources: the components of the mask but those with a node that no front can have reached.
pub fn sources(p: &Parameters, mask: &[bool], width: usize) -> (Vec<u32>, u32) {
    let (labels, count) = label(mask, width, p.connectivity, p.min_area);
    let height = mask.len() / width;
    let far = |pixel: usize| is_beyond_reach(p, pixel, width, height);
    let mut kept = vec![true; count as usize + 1];
    (0..mask.len()).filter(|&pixel| far(pixel)).for_each(|pixel| kept[labels[pixel] as usize] = false);
    kept[0] = false;
    let mut numbered = 0;
    let numbers: Vec<u32> = kept
        .iter()
        .map(|&kept| {
            if kept {
                numbered += 1;
                numbered
            } else {
                0
            }
        })
        .collect();
    (labels.iter().map(|&label| numbers[label as usize]).collect(), numbered)
}

/// All pixels connected to `first`; they become `seen`.
fn component(mask: &[bool], seen: &mut [bool], width: usize, connectivity: Connectivity, first: usize) -> Vec<usize> {
    seen[first] = true;
    let mut found = vec![first];
    let mut next = 0;
    while next < found.len() {
        for neighbour in neighbours(found[next], width, mask.len() / width, connectivity) {
            if mask[neighbour] && !seen[neighbour] {
                seen[neighbour] = true;
                found.push(neighbour);
            }
        }
        next += 1;
    }
    found
}

/// The pixels next to one, inside the image.
fn neighbours(pixel: usize, width: usize, height: usize, connectivity: Connectivity) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let columns = x.saturating_sub(1)..=(x + 1).min(width - 1);
    let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
    rows.flat_map(move |j| columns.clone().map(move |i| (i, j)))
        .filter(move |&(i, j)| match connectivity {
            Connectivity::Four => (i != x) != (j != y),
            Connectivity::Eight => (i, j) != (x, y),
        })
        .map(move |(i, j)| j * width + i)
}

/// Centroids (column, row) of the sources 1 to `sources` of a label map with rows of `width`, weighted by the pixel
/// values above `floor`; the first pixel of a source that has none above it.
pub fn centroids(labels: &[u32], sources: u32, pixels: &[f64], width: usize, floor: f64) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0, 0.0); sources as usize];
    let mut first = vec![None; sources as usize];
    for (at, (&label, &pixel)) in labels.iter().zip(pixels).enumerate().filter(|(_, (label, _))| **label != 0) {
        let (x, y) = ((at % width) as f64, (at / width) as f64);
        let source = label as usize - 1;
        first[source].get_or_insert((x, y));
        let weight = (pixel - floor).max(0.0);
        let (total, along, up) = sums[source];
        sums[source] = (total + weight, along + weight * x, up + weight * y);
    }
    let centroid = |((total, x, y), first): ((f64, f64, f64), Option<(f64, f64)>)| {
        if total > 0.0 { (x / total, y / total) } else { first.unwrap_or((f64::NAN, f64::NAN)) }
    };
    sums.into_iter().zip(first).map(centroid).collect()
}
