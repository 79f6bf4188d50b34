//! Noise and simple sources for tests: Gaussian, with neighbours correlated or not, from a seed.

/// Standard normal numbers, `count` of them.
pub fn gaussian(seed: u64, count: usize) -> Vec<f32> {
    let mut state = seed;
    let mut uniform = move || {
        // SplitMix64.
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + 1e-17
    };
    (0..count).map(|_| ((-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()) as f32).collect()
}

/// Noise of unit variance on a `side` x `side` frame, smoothed with the weights (k, 1, k) along
/// both axes as drizzling and resampling do; k = 0 for none.
pub fn correlated(seed: u64, side: usize, k: f32) -> Vec<f32> {
    let wide = side + 2;
    let white = gaussian(seed, wide * wide);
    let norm = 1.0 + 2.0 * k * k;
    let weight = |step: usize| if step == 1 { 1.0 } else { k };
    let value = |x: usize, y: usize| {
        (0..9).map(|n| weight(n % 3) * weight(n / 3) * white[(y + n / 3) * wide + x + n % 3]).sum::<f32>() / norm
    };
    (0..side * side).map(|at| value(at % side, at / side)).collect()
}

/// Adds a round Gaussian of standard deviation `sigma` and height `peak`.
pub fn add_star(pixels: &mut [f32], width: usize, (x, y): (f32, f32), sigma: f32, peak: f32) {
    for (at, pixel) in pixels.iter_mut().enumerate() {
        let (dx, dy) = ((at % width) as f32 - x, (at / width) as f32 - y);
        *pixel += peak * (-0.5 * (dx * dx + dy * dy) / (sigma * sigma)).exp();
    }
}

/// A galaxy on noise of 1 in 140 x 140 pixels, a bulge in a disc, with a sharp knot around it for each of these shares of
/// its light.
pub fn galaxy_with_knots(seed: u64, shares: &[f32]) -> Vec<f32> {
    const SIDE: usize = 140;
    let (cx, cy) = (70.2, 69.7);
    let mut pixels: Vec<f32> = gaussian(seed, SIDE * SIDE).into_iter().map(|noise| 100.0 + noise).collect();
    for (at, pixel) in pixels.iter_mut().enumerate() {
        let far = ((at % SIDE) as f32 - cx).hypot((at / SIDE) as f32 - cy);
        *pixel += 1500.0 * (-far / 6.0).exp() + 3000.0 * (-far * far / 8.0).exp();
    }
    const LIGHT: f32 = std::f32::consts::TAU * (1500.0 * 36.0 + 3000.0 * 4.0);
    const WIDTH: f32 = 1.2;
    for (number, share) in shares.iter().enumerate() {
        // No two are opposite.
        let (angle, far) = (2.4 * number as f32, 22.0 + 1.5 * (number % 3) as f32);
        let place = (cx + far * angle.cos(), cy + far * angle.sin());
        add_star(&mut pixels, SIDE, place, WIDTH, share * LIGHT / (std::f32::consts::TAU * WIDTH * WIDTH));
    }
    pixels
}
