//! What a user must know of the values of an image, and of its sky, to judge the sources found on it.

use skyfront_core::run::extract::Found;

/// The remarks on a run over `pixels` pixels.
pub fn on(found: &Found, pixels: usize) -> Vec<String> {
    let (values, survey) = (&found.values, found.survey);
    let defined = values.defined as usize;
    let filled = || {
        let share = share(values.filled as usize, pixels);
        format!("{} pixels ({share}) are exactly {}: taken for filling, and as undefined", values.filled, values.fill)
    };
    let undefined =
        || format!("{} of the pixels are undefined: nothing is found there", share(pixels - defined, pixels));
    let saturated = || {
        let top = values.greatest;
        format!("more than a tenth of the pixels have the greatest value, {top}: what is brighter is cut off")
    };
    let crowded = || {
        let crowded = survey.cells - survey.measured;
        format!(
            "{crowded} of the {} cells of the sky are covered with sources: their sky may be too high, and their noise is \
             that of their darkest pixels; --background and --weight can give them",
            survey.cells
        )
    };
    let alone = || {
        format!(
            "{} pixels stand alone: taken for hot pixels and cosmic rays; if stars light single pixels here, --spike-height 0 \
             keeps them",
            found.spikes
        )
    };
    [
        (values.filled > 0).then(filled),
        (2 * defined < pixels).then(undefined),
        values.saturated.then(saturated),
        survey.is_crowded().then(crowded),
        (found.spikes > found.sources).then(alone),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A part of a whole in percent, never rounded to all or nothing.
pub fn share(part: usize, whole: usize) -> String {
    let percent = 100.0 * part as f64 / whole.max(1) as f64;
    match (part, whole) {
        (0, _) => "none".to_owned(),
        (part, whole) if part < whole && percent > 99.9 => "more than 99.9 %".to_owned(),
        _ if percent < 0.1 => "less than 0.1 %".to_owned(),
        _ => format!("{percent:.1} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::sky::{Survey, Values};

    fn found(values: Values, survey: Survey) -> Found {
        Found {
            sources: 0,
            mask_pixels: 0,
            unlabelled: 0,
            regions: 0,
            unreached: 0,
            significance: 5.0,
            photon: 0.0,
            spikes: 0,
            values,
            survey,
        }
    }

    #[test]
    fn an_ordinary_frame_needs_no_remark() {
        let values = Values { defined: 60, ..Values::UNKNOWN };
        let found = found(values, Survey { cells: 4, measured: 2 });
        assert!(on(&Found { spikes: 6, sources: 6, ..found }, 100).is_empty());
    }

    #[test]
    fn every_oddity_is_told_with_its_share() {
        let values = Values { defined: 40, fill: 0.0, filled: 50, saturated: true, greatest: 255.0, ..Values::UNKNOWN };
        let remarks = on(&Found { spikes: 7, sources: 6, ..found(values, Survey { cells: 5, measured: 2 }) }, 100);
        let parts = [
            "50 pixels (50.0 %) are exactly 0",
            "60.0 % of the pixels",
            "greatest value, 255",
            "3 of the 5",
            "7 pixels",
        ];
        assert_eq!(remarks.len(), parts.len());
        for (remark, part) in remarks.iter().zip(parts) {
            assert!(remark.contains(part), "{remark}");
        }
    }

    #[test]
    fn shares_are_not_rounded_to_all_or_nothing() {
        for (part, whole, text) in [
            (0, 5, "none"),
            (1, 9999, "less than 0.1 %"),
            (9998, 9999, "more than 99.9 %"),
            (1, 3, "33.3 %"),
            (5, 5, "100.0 %"),
        ] {
            assert_eq!(share(part, whole), text);
        }
    }
}
