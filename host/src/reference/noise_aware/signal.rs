//! Signal-to-noise and spikes (`default.md`, 1 and 3).

use super::{Judge, Mesh, Plane, neighbours};

/// The two defined pixels between which an undefined one lies.
fn between(defined: &[bool], width: usize, at: usize) -> Option<[usize; 2]> {
    let (x, y, height) = (at % width, at / width, defined.len() / width);
    let row = (x > 0 && x + 1 < width).then(|| [at - 1, at + 1]);
    let column = (y > 0 && y + 1 < height).then(|| [at - width, at + width]);
    [row, column].into_iter().flatten().find(|pair| pair.iter().all(|&at| defined[at]))
}

/// Which pixels have a signal: the defined ones, and those between two.
pub fn has_signal(defined: &[bool], width: usize) -> Vec<bool> {
    (0..defined.len()).map(|at| defined[at] || between(defined, width, at).is_some()).collect()
}

/// The signal-to-noise before spikes are taken out, of which no pixel has more than `brightest`.
pub fn signal(pixels: &[f64], defined: &[bool], mesh: &Mesh, width: usize, brightest: f64) -> Plane {
    let own = |at: usize| {
        let sky = mesh.at(at % width, at / width);
        let signal = (pixels[at] - sky.level) / sky.noise;
        if defined[at] && sky.noise > 0.0 && signal.is_finite() { signal.clamp(-brightest, brightest) } else { 0.0 }
    };
    Plane::from_fn(width, pixels.len() / width, |i, j| {
        let at = j as usize * width + i as usize;
        match between(defined, width, at) {
            Some([before, after]) if !defined[at] => 0.5 * (own(before) + own(after)),
            _ => own(at),
        }
    })
}

/// The signal with the median of the neighbours in place of spikes, that stand alone by more than `least`.
pub fn without_spikes(signal: &Plane, least: f64, judge: &Judge) -> Plane {
    let (width, height) = (signal.width(), signal.height());
    Plane::from_fn(width, height, |i, j| {
        let v = signal.at(i, j);
        let light = |at: usize| signal.values()[at];
        let at = j as usize * width + i as usize;
        let mut near: Vec<f64> = neighbours(at, width, height, 8).into_iter().map(light).collect();
        near.sort_by(f64::total_cmp);
        let n = near.len();
        let median = if n == 0 { 0.0 } else { 0.5 * (near[(n - 1) / 2] + near[n / 2]) };
        let beside: f64 = neighbours(at, width, height, 4).into_iter().map(light).sum();
        let is_spike = least > 0.0
            && judge.exceeds(v, least)
            && judge.exceeds(v - median, least)
            && judge.exceeds(0.25 * v, median.max(0.0) + 1.0)
            && (judge.exceeds(3.5, beside)
                || (judge.exceeds(0.25 * v, beside) && judge.exceeds(v / 3.0 - 2.5, beside)));
        if is_spike { median } else { v }
    })
}
