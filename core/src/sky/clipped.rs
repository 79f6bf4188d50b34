//! The sky of one cell: a clipped estimate of level and noise.

use super::Sky;
use crate::arithmetic::Level;
use crate::sort::{median, ranked};

/// The sky among sorted keys of values. Clipped at three standard deviations until nothing more is
/// clipped (at most ten times), the mode is `2.5 median - 1.5 mean`, or the median where the
/// distribution is skew (Bertin and Arnouts 1996, doi:10.1051/aas:1996164). The noise makes good
/// the 1.5 % that clipping takes.
pub fn clipped(sorted: &[u32]) -> Sky {
    if sorted.len() < 8 {
        return Sky::UNKNOWN;
    }
    let (mut kept, mut centre) = (sorted, median::<f32>(sorted));
    // Half of the values lie within 0.6745 standard deviations; the lower half has no sources.
    let mut noise = (centre - ranked::<f32>(kept, kept.len() / 4)) * 1.4826;
    let mut mean = centre;
    for _ in 0..10 {
        let inside = within(kept, centre, 3.0 * noise);
        if inside.len() < 8 {
            break;
        }
        let over = inside.len() == kept.len();
        (kept, centre) = (inside, median(inside));
        let values = || inside.iter().map(|&key| f64::from(f32::of_key(key)));
        let count = inside.len() as f64;
        let average = values().sum::<f64>() / count;
        let squares: f64 = values().map(|value| (value - average) * (value - average)).sum();
        mean = average as f32;
        noise = libm::sqrt(squares / count) as f32 * 1.015;
        if over {
            break;
        }
    }
    let skew = if mean > centre { mean - centre } else { centre - mean };
    Sky { level: if skew < 0.3 * noise { 2.5 * centre - 1.5 * mean } else { centre }, noise }
}

/// The sorted keys whose values are at most `distance` from `centre`.
fn within(sorted: &[u32], centre: f32, distance: f32) -> &[u32] {
    let near = |&key: &u32| {
        let value = f32::of_key(key);
        (if value > centre { value - centre } else { centre - value }) <= distance
    };
    let first = sorted.iter().position(near).unwrap_or(sorted.len());
    let end = sorted.iter().rposition(near).map_or(first, |last| last + 1);
    sorted.get(first..end).unwrap_or(&[])
}
