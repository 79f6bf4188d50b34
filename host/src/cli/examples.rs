//! Examples of each command, for its help and its manual page.

/// What the program's own page shows, by task.
pub const TASKS: &str = "\
Tasks:
  a first look       skyfront demo
  a FITS image       skyfront segment image.fits --out results
  many images        skyfront segment night1.fits night2.fits --out night --jobs 2
  fainter sources    skyfront segment image.fits --out deep --threshold 0.8
  what can be set    skyfront parameters
  what is measured   skyfront columns
  will it fit        skyfront budget --width 4096 --height 4096
  what came down     skyfront packets downlink.bin
  manual pages       skyfront man --out man1";

/// Commands and their examples: a line of what for, a command line.
pub const EXAMPLES: [(&str, &[(&str, &str)]); 10] = [
    (
        "segment",
        &[
            ("Map, catalogue, pictures and report of an image", "skyfront segment image.fits --out results"),
            (
                "An extension and a weight map",
                "skyfront segment image.fits[SCI] --weight wht.fits --weight-type weight --out results",
            ),
            (
                "Magnitudes, two circles, fainter and smaller sources",
                "skyfront segment image.fits --out deep --threshold 0.8 --min-area 4 --zero-point 25 --apertures 3,5",
            ),
            (
                "SExtractor's columns",
                "skyfront segment image.fits --out results --columns NUMBER,X_IMAGE,Y_IMAGE,FLUX_AUTO,FLAGS",
            ),
            ("The stars of a star tracker's frame", "skyfront segment frame.fits --out stars --preset star-tracker"),
            (
                "A mosaic larger than memory, strip by strip",
                "skyfront segment mosaic.fits --out results --strips --max-memory 2G",
            ),
            ("The settings of one run for another", "skyfront segment --threshold 0.8 --dump-config"),
            ("The front of the paper", "skyfront segment image.fits --out paper --preset paper-f160"),
            (
                "The sources of one band measured in another",
                "skyfront segment r.fits --measure g.fits --out g --no-pictures",
            ),
            (
                "Sources of any colour, in three bands together",
                "skyfront segment r.fits --with g.fits --with i.fits --combine chi2 --out gri",
            ),
        ],
    ),
    (
        "crosscheck",
        &[("Every step of a run beside the reference", "skyfront crosscheck image.fits --preset paper-f160")],
    ),
    ("reproduce", &[("Every caption of the paper, on two simulated skies", "skyfront reproduce --out captions")]),
    ("demo", &[("A simulated sky, segmented and scored", "skyfront demo --out skyfront-demo")]),
    ("budget", &[("Memory of the default for a large frame", "skyfront budget --width 4096 --height 4096")]),
    (
        "simulate",
        &[("A sky of stars, and which pixels are whose", "skyfront simulate --kind stars --seed 7 --out sky")],
    ),
    (
        "score",
        &[("A map beside the truth", "skyfront score sky/truth.fits map/segmentation.fits --image sky/sky.fits")],
    ),
    ("packets", &[("What a star tracker sent down", "skyfront packets downlink.bin")]),
    ("man", &[("Read a page", "skyfront man segment"), ("Install all of them", "skyfront man --out man1")]),
    ("completions", &[("For bash", "skyfront completions bash")]),
];

/// The examples of a command as text; none where it needs none.
pub fn of(command: &str) -> Option<String> {
    let (_, examples) = EXAMPLES.iter().find(|(name, _)| *name == command)?;
    let lines = examples.iter().map(|(what, line)| format!("  {what}:\n    {line}"));
    Some(format!("Examples:\n{}", lines.collect::<Vec<_>>().join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::command;

    #[test]
    fn every_example_is_a_command_line() {
        let tasks = TASKS.lines().skip(1).map(|line| &line[line.find("skyfront").expect("a command line")..]);
        let lines =
            EXAMPLES.iter().flat_map(|(command, examples)| examples.iter().map(move |example| (*command, example.1)));
        for (name, line) in lines.chain(tasks.map(|line| (line.split(' ').nth(1).expect("a command"), line))) {
            assert!(line.starts_with(&format!("skyfront {name}")), "{line}");
            let parsed = command().try_get_matches_from(line.split(' '));
            assert!(parsed.is_ok(), "{line}: {}", parsed.err().map(|error| error.to_string()).unwrap_or_default());
        }
    }

    #[test]
    fn every_command_with_options_has_examples() {
        for subcommand in command().get_subcommands().filter(|one| one.get_arguments().count() > 0) {
            let name = subcommand.get_name();
            assert!(of(name).is_some() || ["columns", "help"].contains(&name), "{name}");
        }
    }
}
