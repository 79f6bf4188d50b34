//! Checks for people and for programs.

use super::Check;
use serde_json::{Value, json};
use std::fmt::Write;

/// A table of one configuration's checks under a caption.
pub fn table(caption: &str, checks: &[Check]) -> String {
    let mut text = String::new();
    for check in checks {
        let (c, failures) = (&check.comparison, check.failures());
        let verdict = if failures.is_empty() { "ok".to_owned() } else { format!("FAILED: {}", failures.join(", ")) };
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{caption} {}: {verdict}", check.arithmetic);
        let _ = writeln!(text, "  {:<12} {:>10} {:>10} {:>10}", "step", "difference", "beyond", "allowed");
        for d in &check.steps {
            let allowed = check.tolerances.of_step(d.step);
            let _ = writeln!(text, "  {:<12} {:>10.2e} {:>10.2e} {:>10.2e}", d.step, d.max, d.beyond, allowed);
        }
        let _ = writeln!(
            text,
            "  whole run: steps {} ({}), t {:.4} ({:.4}), sources {} ({})",
            c.steps.0, c.steps.1, c.t.0, c.t.1, c.sources.0, c.sources.1
        );
        let _ = writeln!(
            text,
            "  mask pixels {}, label pixels {}, centroids {:.2e} px, u {:.2e}",
            c.mask_pixels,
            c.label_pixels,
            c.centroid_shift,
            c.stages.last().map_or(0.0, |d| d.max)
        );
    }
    text
}

/// One check as JSON; a centroid without a partner is `null`.
pub fn json(scheme: &str, check: &Check) -> Value {
    let c = &check.comparison;
    let both = |core: Value, reference: Value| json!({ "core": core, "reference": reference });
    let steps = check.steps.iter().map(|d| {
        let allowed = check.tolerances.of_step(d.step);
        json!({ "step": d.step, "max": d.max, "beyond": d.beyond, "allowed": allowed })
    });
    let planes = c.stages.iter().map(|d| json!({ "stage": d.stage, "max": d.max, "rms": d.rms }));
    json!({
        "scheme": scheme,
        "arithmetic": check.arithmetic,
        "compared": steps.collect::<Vec<_>>(),
        "whole_run": {
            "steps": both(c.steps.0.into(), c.steps.1.into()),
            "t": both(c.t.0.into(), c.t.1.into()),
            "sources": both(c.sources.0.into(), c.sources.1.into()),
            "stages": planes.collect::<Vec<_>>(),
            "mask_pixels": c.mask_pixels,
            "label_pixels": c.label_pixels,
            "centroid_shift": c.centroid_shift,
        },
        "failures": check.failures(),
    })
}
