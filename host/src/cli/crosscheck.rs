//! `skyfront crosscheck`: the core beside the f64 reference, and test vectors for other hardware.

use super::beside::place;
use super::memory::image_within;
use super::say::{Stderr, Stdout};
use super::{Options, Usage};
use crate::choices::ArithmeticOption;
use crate::crosscheck::{Tolerances, crosscheck_together, json, table, unheard_of};
use crate::input::{Combine, Input, Maps};
use crate::provenance::scheme_name;
use crate::read::{HduChoice, Image, Place};
use crate::vectors::{self, INPUT, MANIFEST, Trace};
use crate::write::Products;
use anyhow::{Context, Result, bail};
use clap::{Args, Parser};
use serde_json::{Value as Json, json};
use skyfront_core::config::{Config, Scheme, Value};
use std::path::{Path, PathBuf};

/// Bytes per pixel that a comparison takes at most: the planes of both sides in each of their steps.
const BYTES: u64 = 300;
/// The same for each further image.
const BYTES_TOGETHER: u64 = 150;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The image: FITS (also .gz, .fz), PGM or PNG.
    #[arg(required_unless_present = "from_vectors")]
    image: Option<PathBuf>,
    /// HDU of the image: a number (0 = primary) or a name [default: the first 2-D image].
    #[arg(long, value_name = "N|NAME")]
    hdu: Option<HduChoice>,
    /// Search this image and the first together, as segment does. Of the same pixels and coordinates; can be given many
    /// times.
    #[arg(long, value_name = "IMAGE2", value_parser = place(), conflicts_with_all = ["vectors", "from_vectors"])]
    with: Vec<Place>,
    /// How they are searched together [default: weighted].
    #[arg(long, value_enum, value_name = "HOW", requires = "with")]
    combine: Option<Combine>,
    /// With a preset of the paper and without --scheme, each of the paper's four is checked at the paper's time step
    /// for it.
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    limits: Limits,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write the image, the parameters and every stage of the core's runs into this folder.
    #[arg(long, value_name = "DIR")]
    vectors: Option<PathBuf>,
    /// Replace vectors that exist.
    #[arg(long)]
    overwrite: bool,
    /// Instead of an image: run what such a folder describes and compare every stage with it, bit by bit.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["image", "hdu", "vectors"])]
    from_vectors: Option<PathBuf>,
}

/// Limits that take the place of those of every arithmetic.
#[derive(Debug, Args)]
#[command(next_help_heading = "Tolerances of a step from the same input [defaults: f32, q24, q11]")]
struct Limits {
    /// Largest difference of normalised values [5e-7, 5e-7, 1.6e-5].
    #[arg(long, value_name = "X", value_parser = limit)]
    max_normalised: Option<f64>,
    /// Largest difference of rescaled values, and of each step of the filter [5e-7, 5e-7, 1.6e-5].
    #[arg(long, value_name = "X", value_parser = limit)]
    max_rescaled: Option<f64>,
    /// Largest difference of the edge detector [5e-7 (1 + 1/(1 - c2)), the same, 1.5e-5 more].
    #[arg(long, value_name = "X", value_parser = limit)]
    max_edge: Option<f64>,
    /// Largest difference of each step of the front, in its own unit, u or pixels in a band
    /// [5e-7 times the band, the same, 3.7e-4].
    #[arg(long, value_name = "X", value_parser = limit)]
    max_front: Option<f64>,
    /// Largest shift of a centroid, pixels [1e-3].
    #[arg(long, value_name = "PX", value_parser = limit)]
    max_centroid: Option<f64>,
    /// Steps that the whole run may take more or fewer than the reference's [not asked].
    #[arg(long, value_name = "N")]
    max_steps: Option<u32>,
    /// Pixels of the mask that the whole runs may differ in [not asked].
    #[arg(long, value_name = "N")]
    max_pixels: Option<usize>,
}

/// A limit: a number that is not below 0.
fn limit(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if number >= 0.0 { Ok(number) } else { Err("a limit must be at least 0".to_owned()) }
}

impl Limits {
    fn apply(&self, given: Tolerances) -> Tolerances {
        Tolerances {
            normalised: self.max_normalised.unwrap_or(given.normalised),
            rescaled: self.max_rescaled.unwrap_or(given.rescaled),
            edge: self.max_edge.unwrap_or(given.edge),
            front: self.max_front.unwrap_or(given.front),
            centroid: self.max_centroid.unwrap_or(given.centroid),
            steps: self.max_steps,
            pixels: self.max_pixels,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    match (&arguments.from_vectors, &arguments.image) {
        (Some(folder), _) => replay(folder),
        (None, Some(path)) => {
            if let Some(what) = unheard_of(&arguments.options.config()?) {
                bail!(Usage(what));
            }
            let together = arguments.with.len() as u64;
            let image = image_within(BYTES + BYTES_TOGETHER * together, path, arguments.hdu.as_ref())?;
            let configs: Vec<Config> = configs(&arguments.options)?
                .into_iter()
                .map(|config| arguments.options.for_frame(config, image.width, image.height))
                .collect();
            if let Some(folder) = &arguments.vectors {
                if configs.iter().any(|config| config.sky.is_known()) {
                    bail!(Usage("--vectors are those of a front on pixel values: name a preset with --sky none"));
                }
                export(folder, &configs, &image, arguments.overwrite)?;
            }
            let combine = arguments.combine.unwrap_or_default();
            if combine == Combine::Vector {
                configs.iter().try_for_each(|config| ArithmeticOption::F32.serves(config, arguments.with.len() + 1))?;
            }
            let maps = Maps { with: arguments.with.clone(), combine, ..Maps::default() };
            check(arguments, &configs, &maps.over(&path.display().to_string(), image)?, combine)
        }
        (None, None) => bail!("an image or --from-vectors is wanted"),
    }
}

/// The schemes of the paper.
const PAPERS: [Scheme; 4] = [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature];

/// One configuration per scheme: the one that was chosen, by itself or with a preset on signal-to-noise or of another
/// front, or else all of the paper's.
fn configs(options: &Options) -> Result<Vec<Config>> {
    let config = options.config()?;
    let is_papers = PAPERS.contains(&config.scheme) && !config.sky.is_known();
    if options.given.get("scheme").is_some() || !is_papers {
        return Ok(vec![config]);
    }
    let with = |scheme: Scheme| {
        let given = options.given.with("scheme", Value::word(scheme.name()));
        Options { given, ..options.clone() }.config()
    };
    PAPERS.into_iter().map(with).collect()
}

fn check(arguments: &Arguments, configs: &[Config], input: &Input, combine: Combine) -> Result<()> {
    let name = &input.detected.name;
    let (mut results, mut failed, mut made) = (Vec::new(), 0, 0);
    for config in configs {
        let scheme = scheme_name(config.scheme);
        let checks = crosscheck_together(config, input, combine, |given| arguments.limits.apply(given))
            .with_context(|| format!("{name}: {scheme}"))?;
        failed += checks.iter().filter(|check| !check.failures().is_empty()).count();
        made += checks.len();
        if arguments.json {
            results.extend(checks.iter().map(|check| json(scheme, check)));
        } else {
            write!(Stdout, "{}", table(scheme, &checks))?;
        }
    }
    if arguments.json {
        writeln!(Stdout, "{}", json!({ "input": name, "passed": failed == 0, "checks": results }))?;
    }
    if failed > 0 {
        bail!("{name}: {failed} of {made} checks exceed a tolerance");
    }
    Ok(())
}

fn export(folder: &Path, configs: &[Config], image: &Image, overwrite: bool) -> Result<()> {
    let (width, height) = (image.width, image.height);
    let runs: Result<Vec<(&Config, Vec<Trace>)>> =
        configs.iter().map(|config| Ok((config, vectors::traces(config, &image.pixels, width, height)?))).collect();
    let runs = runs?;
    let mut files = vec![(INPUT.to_owned(), vectors::input_bytes(&image.pixels))];
    let manifest = json!({
        "program": concat!("skyfront ", env!("CARGO_PKG_VERSION")),
        "width": width,
        "height": height,
        "input": { "file": INPUT, "crc32": vectors::crc(&files[0].1) },
        "configurations": runs.iter().map(|(config, traces)| vectors::describe(config, traces)).collect::<Vec<_>>(),
    });
    for (config, traces) in &runs {
        for trace in traces {
            let planes = trace.planes.iter();
            files.extend(planes.map(|p| (vectors::file_name(config.scheme, trace.arithmetic, p), p.bytes.clone())));
        }
    }
    files.push((MANIFEST.to_owned(), format!("{manifest:#}\n").into_bytes()));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let mut products = Products::plan(folder, &names, overwrite)?;
    for (name, bytes) in &files {
        products.write(name, |out| out.write_all(bytes))?;
    }
    products.publish()?;
    writeln!(Stderr, "{} files in {}", files.len(), folder.display());
    Ok(())
}

/// The options of a configuration in a manifest, as on a command line.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct Line {
    #[command(flatten)]
    options: Options,
}

fn replay(folder: &Path) -> Result<()> {
    let path = folder.join(MANIFEST);
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let manifest: Json = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    let side = |name: &str| manifest[name].as_u64().and_then(|n| usize::try_from(n).ok());
    let (Some(width), Some(height)) = (side("width"), side("height")) else {
        bail!("{}: no width and height", path.display());
    };
    let bytes = std::fs::read(folder.join(INPUT)).with_context(|| folder.join(INPUT).display().to_string())?;
    if manifest["input"]["crc32"] != vectors::crc(&bytes)
        || Some(bytes.len()) != width.checked_mul(height).and_then(|pixels| pixels.checked_mul(4))
    {
        bail!("{}: not the image that {MANIFEST} describes", folder.join(INPUT).display());
    }
    let (samples, _) = bytes.as_chunks::<4>();
    let pixels: Vec<f32> = samples.iter().map(|&sample| f32::from_le_bytes(sample)).collect();
    let (mut compared, mut problems) = (0, Vec::new());
    for configuration in manifest["configurations"].as_array().into_iter().flatten() {
        let config = configuration_of(&configuration["options"])?;
        for run in configuration["runs"].as_array().into_iter().flatten() {
            let arithmetic = run["arithmetic"].as_str().unwrap_or_default();
            let caption = format!("{} {arithmetic}", scheme_name(config.scheme));
            compared += 1;
            match vectors::trace(arithmetic, &config, &pixels, width, height)? {
                None => problems.push(format!("{caption}: this program has no such arithmetic or cannot serve it")),
                Some(trace) => problems.extend(first_difference(run, &trace).map(|what| format!("{caption}: {what}"))),
            }
        }
    }
    problems.iter().try_for_each(|problem| writeln!(Stdout, "{problem}"))?;
    if compared == 0 {
        bail!("{}: no run to replay", path.display());
    }
    if !problems.is_empty() {
        bail!("{}: {} of {compared} runs differ", folder.display(), problems.len());
    }
    writeln!(Stdout, "{compared} runs give the same bits in every stage")?;
    Ok(())
}

/// The configuration that the options of a manifest amount to.
fn configuration_of(options: &Json) -> Result<Config> {
    let options = options.as_object().context("a configuration without options")?;
    let given = options.iter().flat_map(|(name, value)| {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        [format!("--{name}"), value]
    });
    // All vectors are those of a front.
    let preset = ["--preset", "paper-f160"].map(str::to_owned).into_iter().filter(|_| !options.contains_key("preset"));
    Line::try_parse_from(preset.chain(given)).context("options of the vectors")?.options.config()
}

/// The first stage of a run in a manifest whose digest is not that of the trace.
fn first_difference(run: &Json, trace: &Trace) -> Option<String> {
    let stages = run["stages"].as_array().map_or(&[][..], Vec::as_slice);
    if stages.len() != trace.planes.len() {
        return Some(format!("{} stages, not {}", trace.planes.len(), stages.len()));
    }
    let mut pairs = stages.iter().zip(&trace.planes);
    let (wanted, plane) = pairs.find(|(wanted, plane)| wanted["crc32"] != vectors::crc(&plane.bytes))?;
    Some(format!("{} is {}, not {}", plane.name, vectors::crc(&plane.bytes), wanted["crc32"]))
}
