//! The photon noise (`default.md`, 3).

use super::{Plane, median, sample};

/// `a` of the variance `1 + a v`.
pub fn photon_noise(signal: &Plane, fine: &Plane, masked: &[bool]) -> f64 {
    let (width, height, brightness) = (signal.width(), signal.height(), fine.values());
    let second_difference = |at: usize| {
        let (x, y) = (at % width, at / width);
        let inner = x > 0 && x + 1 < width && y > 0 && y + 1 < height;
        let v = signal.around(x as isize, y as isize);
        inner.then_some((v.sw - 2.0 * v.s + v.se - 2.0 * (v.w - 2.0 * v.c + v.e) + v.nw - 2.0 * v.n + v.ne).abs())
    };
    let size = |pixels: &mut dyn Iterator<Item = usize>| {
        let mut sizes: Vec<f64> = pixels.filter_map(second_difference).collect();
        sizes.sort_by(f64::total_cmp);
        (sizes.len() >= 100).then(|| median(&sizes))
    };
    let Some(sky) = size(&mut sample(masked.len()).filter(|&at| !masked[at])).filter(|&sky| sky > 0.0) else {
        return 0.0;
    };
    let levels = [4.0, 8.0, 16.0, 32.0].into_iter().filter_map(|from| {
        let level = size(&mut (0..masked.len()).filter(|&at| (from..2.0 * from).contains(&brightness[at])))?;
        Some(((level / sky).powi(2) - 1.0) / (2f64.sqrt() * from))
    });
    levels.reduce(f64::min).unwrap_or(0.0).max(0.0)
}

/// n: the noise of a pixel of brightness `v`, in that of a pixel without light.
pub fn grown(photon: f64, v: f64) -> f64 {
    (1.0 + 1.5 * photon * v.max(0.0)).sqrt()
}
