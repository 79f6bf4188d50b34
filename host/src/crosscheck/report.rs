//! Checks for people and for programs.

use super::Check;
use serde_json::{Value, json};
use std::fmt::Write;

/// A table of one configuration's checks under a caption.
pub fn table(caption: &str, checks: &[Check]) -> String {
    let mut text = String::new();
    for check in checks {
        let c = &check.comparison;
        let failures = check.failures();
        let verdict = if failures.is_empty() { "ok".to_owned() } else { format!("FAILED: {}", failures.join(", ")) };
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{caption} {}: {verdict}", check.arithmetic);
        let _ = writeln!(
            text,
            "  steps {} ({}), t {:.4} ({:.4}), sources {} ({})",
            c.steps.0, c.steps.1, c.t.0, c.t.1, c.sources.0, c.sources.1
        );
        let _ = writeln!(text, "  {:<12} {:>10} {:>10}", "difference", "max", "rms");
        for d in &c.stages {
            let _ = writeln!(text, "  {:<12} {:>10.2e} {:>10.2e}", d.stage, d.max, d.rms);
        }
        let _ = writeln!(
            text,
            "  mask pixels {}, label pixels {}, centroids {:.2e} px",
            c.mask_pixels, c.label_pixels, c.centroid_shift
        );
    }
    text
}

/// One check as JSON; a centroid without a partner is `null`.
pub fn json(scheme: &str, check: &Check) -> Value {
    let (c, t) = (&check.comparison, &check.tolerances);
    let both = |core: Value, reference: Value| json!({ "core": core, "reference": reference });
    let stages: Vec<Value> = c.stages.iter().map(|d| json!({ "stage": d.stage, "max": d.max, "rms": d.rms })).collect();
    json!({
        "scheme": scheme,
        "arithmetic": check.arithmetic,
        "steps": both(c.steps.0.into(), c.steps.1.into()),
        "t": both(c.t.0.into(), c.t.1.into()),
        "sources": both(c.sources.0.into(), c.sources.1.into()),
        "stages": stages,
        "mask_pixels": c.mask_pixels,
        "label_pixels": c.label_pixels,
        "centroid_shift": c.centroid_shift,
        "tolerances": {
            "normalised": t.normalised,
            "rescaled": t.rescaled,
            "edge": t.edge,
            "front": t.front,
            "steps": t.steps,
            "pixels": t.pixels,
            "centroid": t.centroid,
        },
        "failures": check.failures(),
    })
}
