//! The table of all parameters: what can be set is told here, once.
//!
//! From it follow the checks and their messages, the digest in snapshots, and on a host the options,
//! the keys of configuration files, the headers of results and the manual. A new setting is a field
//! of [`Config`] and an entry here.

use super::parameter::{Access, Bounds, End, Need, Numbers, Parameter, Range, Slot, Step, Value, Word, word};
use super::{
    Background, Config, Connectivity, CurvatureForm, Diffusivity, Edge, Filter, MAX_STEPS, Motion, Normalize, Order,
    Rescale, Scheme, Select, Separate, Start, Stop, Tau,
};
use super::{filter, scheme};
use crate::arithmetic::digest::Digest;
use crate::error::Error;
use Slot::{Long, Real, Short};

/// Makes the table of its rows, and what goes through all of it row by row: unrolled, so that a
/// program for a small processor holds of the table only what it uses.
macro_rules! table {
    ($($row:expr),+ $(,)?) => {
        /// All parameters in the order in which they are set: a choice before what depends on it.
        pub static PARAMETERS: &[Parameter] = &[$($row),+];

        /// Checks every value of a configuration.
        #[inline(always)]
        pub(super) fn check(config: &Config) -> Result<(), Error> {
            $({ const ROW: Parameter = $row; ROW.check(config)?; })+
            Ok(())
        }

        /// Feeds every value of a configuration to a digest.
        #[inline(always)]
        pub(super) fn feed(config: &Config, digest: &mut Digest) {
            $({ const ROW: Parameter = $row; ROW.feed(config, digest); })+
        }
    };
}

table![
    choice("sky", "SFSKY", SKIES, sky, set_sky)
        .at(Step::Sky, &[])
        .common()
        .ranges_by(|_| [Range::within(16.0, 4096.0); 2])
        .help(
            "How sky and noise are measured. With them the run is on signal-to-noise, with none on pixel \
             values, as the paper's is.",
        ),
    real("threshold", "SFTHRESH", |c| Some(Real(&mut c.outline.threshold)))
        .at(Step::Sky, &[ON_SIGNAL])
        .common()
        .unit("sigma")
        .range(Range::within(0.1, 100.0))
        .help(
            "Detection threshold, in standard deviations of a pixel's noise above the sky. Outlines lie \
             where the smoothed image reaches it.",
        ),
    real("spike-height", "SFSPIKE", |c| Some(Real(&mut c.spike_height)))
        .at(Step::Sky, &[ON_SIGNAL])
        .common()
        .unit("sigma")
        .range(Range::within(0.0, 1e6))
        .help(
            "A pixel that stands alone by more than this is a hot pixel or a cosmic ray, and no source; 0 takes none \
             for one, where stars light single pixels.",
        ),
    choice("dx", "SFDX", &[], |c| Some(Value::of(Numbers::One(c.dx))), set_dx)
        .numbers(Numbers::One(0.0))
        .at(Step::Normalize, &[IN_UNITS])
        .range(Range::above(0.0, End::At(1e3)))
        .help("Width of a pixel in the paper's unit of length, that of gradients and of the front's way."),
    choice("normalize", "SFNORM", NORMALIZATIONS, normalize, set_normalize)
        .at(Step::Normalize, &[NORMALISED])
        .ranges_by(|_| [Range::within(0.0, 1e6), Range::above(0.0, End::At(1e6))])
        .help("How pixel values become numbers in [0, 1]."),
    choice("range", "SFRANGE", &[], range, set_range)
        .numbers(Numbers::Two(0.0, 0.0))
        .at(Step::Normalize, &[NORMALISED, Need::of("normalize", &["percentile"])])
        .unit("%")
        .ranges_by(|c| {
            let low = if let Normalize::Percentile { low, .. } = c.normalize { low } else { 0.0 };
            [Range { least: End::At(0.0), most: End::Open }, Range::above(low, End::At(100.0))]
        })
        .help("Percentiles of the pixel values that become 0 and 1."),
    choice("rescale", "SFRESC", RESCALINGS, rescale, set_rescale)
        .at(Step::Rescale, &[BY_PAPER])
        .help("Rescaling of intensities, which lifts faint sources above the sky."),
    real("alpha", "SFALPHA", |c| match &mut c.rescale {
        Rescale::R1 { alpha } | Rescale::R2 { alpha } => Some(Real(alpha)),
        Rescale::R3 { .. } | Rescale::None => None,
    })
    .at(Step::Rescale, &[BY_PAPER, Need::of("rescale", &["r1", "r2"])])
    .range(Range::above(0.0, End::Beyond(1.0)))
    .help("Exponent of r1 and r2; the smaller, the more faint light is lifted."),
    whole("beta", "SFBETA", |c| match &mut c.rescale {
        Rescale::R3 { beta, .. } => Some(Short(beta)),
        _ => None,
    })
    .at(Step::Rescale, &[BY_PAPER, BY_R3])
    .range(Range::within(1.0, 65_535.0))
    .help("Exponent of r3; the greater, the steeper the passage at tau."),
    choice("tau", "SFTAU", THRESHOLDS, tau, set_tau)
        .numbers(Numbers::One(0.0))
        .at(Step::Rescale, &[BY_PAPER, BY_R3])
        .ranges_by(|c| match c.rescale {
            Rescale::R3 { tau: Tau::Noise { .. }, .. } => [Range::above(0.0, End::At(1e3)); 2],
            _ => [Range::above(0.0, End::Beyond(1.0)); 2],
        })
        .help(
            "Where r3 begins to lift light: found by a rule in the image that is rescaled, or a value \
             between 0 and 1.",
        ),
    choice("filter", "SFFILTER", filter::WORDS, filter::get, filter::set)
        .at(Step::Filter, &[])
        .ranges_by(filter::ranges)
        .help("How noise is smoothed away."),
    whole("filter-steps", "SFFSTEPS", |c| Some(Short(&mut c.filter_steps)))
        .at(Step::Filter, &[FILTERED])
        .ranges_by(filter::step_ranges)
        .help("Steps of the filter; of starlet the scales, 7 at most."),
    real("filter-dt", "SFFDT", |c| Some(Real(&mut c.filter_dt)))
        .at(Step::Filter, &[DIFFUSED])
        .ranges_by(|c| [Range::above(0.0, End::About(c.dx * c.dx / 4.0)); 2])
        .help("Time step of the filter, at most dx^2/4."),
    choice("pm", "SFPM", DIFFUSIVITIES, diffusivity, set_diffusivity)
        .at(Step::Filter, &[PERONA_MALIK])
        .help("Diffusion coefficient of Perona and Malik, of s = |grad I| / mu."),
    real("pm-mu", "SFPMMU", |c| match &mut c.filter {
        Filter::PeronaMalik { mu, .. } => Some(Real(mu)),
        _ => None,
    })
    .at(Step::Filter, &[PERONA_MALIK])
    .range(Range::above(0.0, End::At(1e6)))
    .help(
        "Gradient at which Perona and Malik's filter stops smoothing, of values in [0, 1] per dx. The \
         paper's 30 is nearly the heat filter; 2 keeps edges.",
    ),
    choice("order", "SFORDER", ORDERS, order, set_order)
        .at(Step::Filter, &[BY_PAPER, Need::of("rescale", &["r1", "r2", "r3"]), FILTERED])
        .help("Whether to rescale or to filter first."),
    choice("edge", "SFEDGE", EDGES, edge, set_edge)
        .at(Step::Speed, &[EDGE_HELD])
        .help("Edge detector, the speed of the front: 1 in flat places, 0 on edges."),
    real("p", "SFP", |c| if let Edge::G1 { p } = &mut c.edge { Some(Real(p)) } else { None })
        .at(Step::Speed, &[EDGE_HELD, Need::of("edge", &["g1"])])
        .range(Range::within(1.0, 1e6))
        .help("Exponent of g1."),
    real("c2", "SFC2", |c| if let Edge::G2Mod { c2 } = &mut c.edge { Some(Real(c2)) } else { None })
        .at(Step::Speed, &[EDGE_HELD, Need::of("edge", &["g2mod"])])
        .range(Range { least: End::At(0.0), most: End::Beyond(1.0) })
        .help("Constant of g2mod: the front is held where g2 is below it."),
    choice("scheme", "SFSCHEME", scheme::WORDS, |c| Some(Value::word(c.scheme.name())), set_scheme)
        .at(Step::Front, &[])
        .common()
        .help("Scheme that moves the front."),
    whole("outline-steps", "SFOSTEPS", |c| Some(Long(&mut c.outline.steps)))
        .at(Step::Front, &[BY_REGION])
        .range(Range::within(0.0, 1000.0))
        .help("Steps of the front that starts where the smoothed image reaches the threshold; 0 leaves it there."),
    real("outline-curvature", "SFOCURV", |c| Some(Real(&mut c.outline.curvature)))
        .at(Step::Front, &[BY_REGION])
        .unit("px sigma")
        .range(Range::within(0.0, 1.0))
        .help("Weight of that front's curvature: how smooth the outlines are."),
    real("nu", "SFNU", |c| Some(Real(&mut c.nu)))
        .at(Step::Front, &[BENT])
        .ranges_by(|c| [Range { least: End::At(0.0), most: End::About(c.greatest_nu()) }; 2])
        .help("Weight of the curvature."),
    choice("curvature-form", "SFCURV", CURVATURE_FORMS, curvature_form, set_curvature_form)
        .at(Step::Front, &[BENT])
        .help("Form of the averages in the curvature."),
    real("degenerate", "SFDEGEN", |c| Some(Real(&mut c.degenerate)))
        .at(Step::Front, &[FLATTENED])
        .range(Range::above(0.0, End::At(1e3)))
        .help("Slope of the front, times dx, up to which it counts as flat where its curvature is taken."),
    whole("degenerate-power", "SFDEGPOW", |c| Some(Short(&mut c.degenerate_power)))
        .at(Step::Front, &[BENT])
        .range(Range::within(0.0, 8.0))
        .help("Power of dx in that slope."),
    choice("directions", "SFDIRS", DIRECTIONS, directions, set_directions)
        .at(Step::Front, &[Need::of("scheme", &["sl", "sl-curvature"])])
        .help("Directions of the semi-Lagrangian minimum."),
    real("mu", "SFMU", |c| Some(Real(&mut c.chan_vese.mu)))
        .at(Step::Front, &[BY_MEANS])
        .range(Range::within(0.0, 10.0))
        .help(
            "Weight of the contour's length, in squared image units times the paper's unit of length. \
             (That of Perona and Malik is pm-mu.)",
        ),
    real("lambda1", "SFLAMB1", |c| Some(Real(&mut c.chan_vese.lambda1)))
        .at(Step::Front, &[CHAN_VESE])
        .range(Range::above(0.0, End::At(10.0)))
        .help("Weight of the variance inside."),
    real("lambda2", "SFLAMB2", |c| Some(Real(&mut c.chan_vese.lambda2)))
        .at(Step::Front, &[CHAN_VESE])
        .range(Range::above(0.0, End::At(10.0)))
        .help("Weight of the variance outside."),
    choice("start", "SFSTART", STARTS, start, set_start).at(Step::Front, &[STARTED]).help("Where the front starts."),
    real("margin", "SFMARGIN", |c| match &mut c.start {
        Start::Threshold { margin } => Some(Real(margin)),
        _ => None,
    })
    .at(Step::Front, &[STARTED, Need::of("start", &["threshold", "map"])])
    .unit("px")
    .range(Range::within(1.0, 100.0))
    .help("Distance from the outline of the threshold or the map to the front that starts there."),
    choice("motion", "SFMOTION", MOTIONS, motion, set_motion)
        .at(Step::Front, &[EDGE_HELD, Need::of("start", &["map"])])
        .help("Which way the front moves."),
    real("dt", "SFDT", |c| Some(Real(&mut c.dt)))
        .at(Step::Front, &[STEPPED])
        .ranges_by(|c| [Range::above(0.0, End::About(c.longest_step())); 2])
        .help(
            "Time step of the front. It follows from scheme and dx: dx/4 for fd and fd-filtered, dx^2 for \
             fd-curvature, dx for sl and sl-curvature, 8 for chan-vese and multiphase.",
        ),
    real("t-max", "SFTMAX", |c| Some(Real(&mut c.t_max)))
        .at(Step::Front, &[BY_PAPER])
        .ranges_by(|c| [Range::above(0.0, End::At(c.dt * MAX_STEPS as f32)); 2])
        .help(
            "The front is given up at this time. Not given, it is at least 5/3 of the image's shorter side \
             times dx, so that the front can cross it; 1600 for chan-vese and multiphase."
        ),
    choice("band", "SFBAND", &[word("none", "")], band, set_band)
        .numbers(Numbers::One(0.0))
        .at(Step::Front, &[NEAR_FRONT])
        .unit("px")
        .range(Range::within(2.0, 1e4))
        .help(
            "Half-width at which the front is saturated, so that only its surroundings cost time. With none \
             it is the paper's front; 8 changes fewer than 0.2 % of the pixels.",
        ),
    real("eps-front", "SFEPSF", |c| Some(Real(&mut c.eps_front)))
        .at(Step::Front, &[NEAR_FRONT])
        .range(Range::above(0.0, End::At(1e6)))
        .help("Pixels with |u| up to here count as near the front."),
    real("eps", "SFEPS", |c| Some(Real(&mut c.eps)))
        .at(Step::Front, &[STEPPED])
        .range(Range::above(0.0, End::At(1e6)))
        .help("Tolerance of the stopping rule."),
    choice("stop", "SFSTOP", STOPS, stop, set_stop)
        .at(Step::Front, &[STEPPED])
        .help("When the front counts as stopped."),
    choice("separate", "SFSEPAR", SEPARATIONS, separate, set_separate)
        .at(Step::Separate, &[])
        .help("How outlined pixels become sources."),
    choice("connectivity", "SFCONN", CONNECTIVITIES, connectivity, set_connectivity)
        .at(Step::Separate, &[])
        .common()
        .help("Which pixels of a source touch."),
    real("deblend-contrast", "SFCONTR", |c| Some(Real(&mut c.deblending.contrast)))
        .at(Step::Separate, &[BY_TREE])
        .common()
        .range(Range::within(0.0, 1.0))
        .help("Deblending contrast: least light of a source, as a part of its brighter neighbour's.",),
    real("deblend-light", "SFBRANCH", |c| Some(Real(&mut c.deblending.branch)))
        .at(Step::Separate, &[BY_TREE])
        .unit("sigma")
        .range(Range::within(0.0, 1e6))
        .help("Light above the saddle between two peaks that makes the fainter a source of its own."),
    real("deblend-sharpening", "SFSHARP", |c| Some(Real(&mut c.deblending.sharpening)))
        .at(Step::Separate, &[BY_TREE])
        .range(Range::within(0.0, 4.0))
        .help("How much the image is sharpened before it is divided into sources; 0 leaves it smooth."),
    real("deblend-excess", "SFEXCESS", |c| Some(Real(&mut c.deblending.excess)))
        .at(Step::Separate, &[BY_TREE])
        .unit("sigma")
        .range(Range::within(0.0, 1e6))
        .help(
            "Light beyond that of a symmetric source from which pixels become another source: beyond the \
             mirrored light, in the noise of the lightly smoothed image.",
        ),
    whole("deblend-area", "SFREOPEN", |c| Some(Long(&mut c.deblending.reopened_area)))
        .at(Step::Separate, &[BY_TREE])
        .unit("px")
        .range(Range::within(1.0, 1e9))
        .help("Pixels with so much light that such a source needs."),
    whole("deblend-knots", "SFKNOTS", |c| Some(Long(&mut c.deblending.knots)))
        .at(Step::Separate, &[BY_TREE])
        .unit("knots")
        .range(Range::within(0.0, 1e9))
        .help(
            "So many knots in the light of a galaxy, sharp and each with 0.1 to 0.7 percent of it, are no \
             sources of their own; 0 keeps all.",
        ),
    choice("select", "SFSELECT", SELECTIONS, select, set_select).at(Step::Select, &[]).help("Which sources are kept."),
    real("false-sources", "SFFALSE", |c| Some(Real(&mut c.significance.false_sources)))
        .at(Step::Select, &[BY_SIGNIFICANCE])
        .common()
        .unit("per image")
        .range(Range::within(0.001, 1000.0))
        .help("Peaks of pure noise that may be taken for sources in an image, on average."),
    real("false-share", "SFSHARE", |c| Some(Real(&mut c.significance.false_share)))
        .at(Step::Select, &[BY_SIGNIFICANCE])
        .range(Range::within(0.0, 0.5))
        .help("The share of the sources that may be such peaks, where that is more."),
    real("min-peak", "SFPEAK", |c| Some(Real(&mut c.significance.peak)))
        .at(Step::Select, &[BY_SIGNIFICANCE])
        .unit("thresholds")
        .range(Range::within(0.0, 100.0))
        .help(
            "Least peak of a source in the matched image, as a multiple of the threshold, even where the \
             noise would allow less.",
        ),
    real("min-light", "SFLIGHT", |c| Some(Real(&mut c.significance.light)))
        .at(Step::Select, &[BY_SIGNIFICANCE])
        .unit("sigma")
        .range(Range::within(0.0, 1e6))
        .help("Least light of a source, the sum of its pixels."),
    whole("min-area", "SFMINAR", |c| Some(Long(&mut c.min_area)))
        .at(Step::Select, &[])
        .common()
        .unit("px")
        .range(Range::within(1.0, 1e9))
        .help("Smallest area of a source."),
];

impl Need {
    /// Whether a configuration has one of its choices.
    fn is_met(&self, config: &Config) -> bool {
        self.choices().any(|need| {
            let word = Parameter::named(need.name).and_then(|choice| choice.get(config)).and_then(|value| value.word);
            word.is_some_and(|word| need.words.contains(&word))
        })
    }
}

impl Parameter {
    /// The parameter of that name.
    pub fn named(name: &str) -> Option<&'static Parameter> {
        PARAMETERS.iter().find(|parameter| parameter.name == name)
    }

    /// The first choice of a configuration that leaves this parameter unused.
    pub fn unmet(&self, config: &Config) -> Option<&'static Need> {
        self.needs.iter().find(|need| !need.is_met(config))
    }

    /// `config` with the choices that this parameter needs, each the first that serves.
    pub fn at_work(&self, config: &Config) -> Config {
        let mut config = *config;
        for need in self.needs {
            if self.unmet(&config) == Some(need)
                && let (Some(other), Some(&word)) = (Parameter::named(need.name), need.words.first())
                && let Some(value) = other.parse(word)
            {
                // Words are never out of bounds.
                let _ = other.set(&mut config, value);
            }
        }
        config
    }

    /// Its value where nothing is said: that of the default's steps, or of the choices it needs.
    pub fn default(&self) -> Option<Value> {
        self.get(&self.at_work(&Config::NOISE_AWARE))
    }
}

const ON_SIGNAL: Need = Need::of("sky", &["mesh", "frame"]);
const BY_REGION: Need = Need::of("scheme", &["region"]);
const BY_TREE: Need = Need::of("separate", &["tree"]);
const BY_SIGNIFICANCE: Need = Need::of("select", &["significance"]);
/// The paper's schemes, whose front moves over an image with values in [0, 1].
const BY_PAPER: Need = Need::of(
    "scheme",
    &["fd", "sl", "fd-curvature", "sl-curvature", "fd-filtered", "chan-vese", "multiphase", "fast-marching"],
);
/// Filters in steps work on such an image too.
const NORMALISED: Need = BY_PAPER.or(&FILTERED);
/// What goes by the paper's unit of length.
const IN_UNITS: Need = BY_PAPER.or(&DIFFUSED);
/// Those whose front starts somewhere: where four phases begin, the image tells.
const STARTED: Need =
    Need::of("scheme", &["fd", "sl", "fd-curvature", "sl-curvature", "fd-filtered", "chan-vese", "fast-marching"]);
const BY_R3: Need = Need::of("rescale", &["r3"]);
const FILTERED: Need = Need::of("filter", filter::IN_STEPS);
/// Those with a time step.
const DIFFUSED: Need = Need::of("filter", &["heat", "pm"]);
const PERONA_MALIK: Need = Need::of("filter", &["pm"]);
const CHAN_VESE: Need = Need::of("scheme", &["chan-vese"]);
/// Schemes that part the image into regions.
const BY_MEANS: Need = Need::of("scheme", &["chan-vese", "multiphase"]);
const BENT: Need = Need::of("scheme", &["fd-curvature", "sl-curvature"]);
/// Schemes with a flat case of their own.
const FLATTENED: Need = Need::of("scheme", &["fd-curvature", "sl-curvature", "chan-vese", "multiphase"]);
/// Schemes whose front the edge detector holds; Chan and Vese's goes by regions.
const EDGE_HELD: Need =
    Need::of("scheme", &["fd", "sl", "fd-curvature", "sl-curvature", "fd-filtered", "fast-marching"]);
/// Schemes that go by time steps.
const STEPPED: Need =
    Need::of("scheme", &["fd", "sl", "fd-curvature", "sl-curvature", "fd-filtered", "chan-vese", "multiphase"]);
/// Schemes in which only what is near the front moves and tells whether it has stopped.
const NEAR_FRONT: Need = Need::of("scheme", &["fd", "sl", "fd-curvature", "sl-curvature", "fd-filtered"]);

const SKIES: &[Word] = &[
    Word {
        name: "mesh",
        numbers: Numbers::Whole(64),
        help: "in the cells of a mesh, N pixels wide, and smooth between them",
    },
    word("frame", "once for the whole image"),
    word("none", "not at all: no signal-to-noise, but the least memory"),
];
const NORMALIZATIONS: &[Word] = &[
    word("minmax", "by the least and the greatest pixel"),
    word("percentile", "by two percentiles, see range"),
    Word {
        name: "noise",
        numbers: Numbers::Two(3.0, 30.0),
        help: "from LOW standard deviations of the noise below the sky to HIGH above it",
    },
];
const RESCALINGS: &[Word] = &[
    word("none", "as they are"),
    word("r1", "x^alpha"),
    word("r2", "(ln(x + 1) / ln 2)^alpha"),
    word("r3", "dark light damped and bright light lifted, on either side of tau"),
];
const THRESHOLDS: &[Word] = &[
    word("otsu", "two classes of least variance"),
    word("kapur", "greatest entropy"),
    word("rosin", "corner of a histogram with one peak"),
    Word { name: "noise", numbers: Numbers::One(3.0), help: "X standard deviations of the noise above the sky" },
];
const DIFFUSIVITIES: &[Word] = &[word("f1", "1 / (1 + s^2)"), word("f2", "exp(-s^2)")];
const ORDERS: &[Word] =
    &[word("rescale-first", "the algorithm as printed"), word("filter-first", "the paper's Test 2")];
const EDGES: &[Word] = &[
    word("g1", "1 / (1 + |grad I|^p)"),
    word("g2", "falls evenly from the least gradient of the image to the greatest"),
    word("g2mod", "g2 above c2, stretched to [0, 1]"),
];
const CURVATURE_FORMS: &[Word] =
    &[word("consistent", "approximates the equation"), word("printed", "as the paper has it; never settles")];
const DIRECTIONS: &[Word] = &[word("16", ""), word("64", "")];
const STARTS: &[Word] = &[
    word("frame", "at the image's border"),
    word("threshold", "near the objects: outside the pixels above tau, or above Otsu's threshold without r3"),
    word("map", "where a map says"),
];
const MOTIONS: &[Word] = &[
    word("inward", "it shrinks from outside the map's pixels onto the objects"),
    word("outward", "it grows from the map's pixels, the seeds, until edges hold it"),
];
const STOPS: &[Word] =
    &[word("paper", "by its change in a step"), word("rate", "per unit of time, and no pixel changes sign")];
const SEPARATIONS: &[Word] = &[
    word("tree", "divided by the tree of level sets, where they have peaks of their own"),
    word("components", "as connected components"),
];
const SELECTIONS: &[Word] =
    &[word("significance", "those that noise alone would not make"), word("area", "those of at least min-area pixels")];
const CONNECTIVITIES: &[Word] = &[word("4", "those that share an edge"), word("8", "corners too")];

fn sky(config: &Config) -> Option<Value> {
    Some(match config.sky {
        Background::None => Value::word("none"),
        Background::Frame => Value::word("frame"),
        Background::Mesh { size } => Value { word: Some("mesh"), numbers: Numbers::Whole(u32::from(size)) },
    })
}

fn set_sky(config: &mut Config, value: Value) {
    config.sky = match (value.word, value.numbers) {
        (_, Numbers::Whole(size)) => Background::Mesh { size: size as u16 },
        (Some("frame"), _) => Background::Frame,
        _ => Background::None,
    };
}

/// The time step follows.
fn set_dx(config: &mut Config, value: Value) {
    if let Numbers::One(dx) = value.numbers {
        config.dx = dx;
        config.dt = config.scheme.usual_dt(dx);
    }
}

fn normalize(config: &Config) -> Option<Value> {
    Some(match config.normalize {
        Normalize::MinMax => Value::word("minmax"),
        Normalize::Percentile { .. } => Value::word("percentile"),
        Normalize::Noise { below, above } => Value { word: Some("noise"), numbers: Numbers::Two(below, above) },
    })
}

fn set_normalize(config: &mut Config, value: Value) {
    config.normalize = match (value.numbers, config.normalize) {
        (Numbers::Two(below, above), _) => Normalize::Noise { below, above },
        _ if value.is("minmax") => Normalize::MinMax,
        (_, given @ Normalize::Percentile { .. }) => given,
        _ => Normalize::Percentile { low: 0.5, high: 99.9 },
    };
}

fn range(config: &Config) -> Option<Value> {
    match config.normalize {
        Normalize::Percentile { low, high } => Some(Value::of(Numbers::Two(low, high))),
        _ => None,
    }
}

fn set_range(config: &mut Config, value: Value) {
    if let (Normalize::Percentile { low, high }, Numbers::Two(one, other)) = (&mut config.normalize, value.numbers) {
        (*low, *high) = (one, other);
    }
}

fn rescale(config: &Config) -> Option<Value> {
    Some(Value::word(match config.rescale {
        Rescale::None => "none",
        Rescale::R1 { .. } => "r1",
        Rescale::R2 { .. } => "r2",
        Rescale::R3 { .. } => "r3",
    }))
}

fn set_rescale(config: &mut Config, value: Value) {
    let alpha = match config.rescale {
        Rescale::R1 { alpha } | Rescale::R2 { alpha } => alpha,
        Rescale::R3 { .. } | Rescale::None => 0.25,
    };
    config.rescale = match (value.word, config.rescale) {
        (Some("r1"), _) => Rescale::R1 { alpha },
        (Some("r2"), _) => Rescale::R2 { alpha },
        (Some("r3"), given @ Rescale::R3 { .. }) => given,
        (Some("r3"), _) => Rescale::R3 { beta: 8, tau: Tau::Otsu },
        _ => Rescale::None,
    };
}

fn tau(config: &Config) -> Option<Value> {
    let Rescale::R3 { tau, .. } = config.rescale else { return None };
    Some(match tau {
        Tau::Otsu => Value::word("otsu"),
        Tau::Kapur => Value::word("kapur"),
        Tau::Rosin => Value::word("rosin"),
        Tau::Noise { k } => Value { word: Some("noise"), numbers: Numbers::One(k) },
        Tau::Value(value) => Value::of(Numbers::One(value)),
    })
}

fn set_tau(config: &mut Config, value: Value) {
    if let Rescale::R3 { tau, .. } = &mut config.rescale {
        *tau = match (value.word, value.numbers) {
            (None, Numbers::One(value)) => Tau::Value(value),
            (_, Numbers::One(k)) => Tau::Noise { k },
            (Some("kapur"), _) => Tau::Kapur,
            (Some("rosin"), _) => Tau::Rosin,
            _ => Tau::Otsu,
        };
    }
}

fn diffusivity(config: &Config) -> Option<Value> {
    match config.filter {
        Filter::PeronaMalik { diffusivity: Diffusivity::F1, .. } => Some(Value::word("f1")),
        Filter::PeronaMalik { diffusivity: Diffusivity::F2, .. } => Some(Value::word("f2")),
        _ => None,
    }
}

fn set_diffusivity(config: &mut Config, value: Value) {
    if let Filter::PeronaMalik { diffusivity, .. } = &mut config.filter {
        *diffusivity = if value.is("f1") { Diffusivity::F1 } else { Diffusivity::F2 };
    }
}

fn order(config: &Config) -> Option<Value> {
    Some(Value::word(match config.order {
        Order::RescaleFirst => "rescale-first",
        Order::FilterFirst => "filter-first",
    }))
}

fn set_order(config: &mut Config, value: Value) {
    config.order = if value.is("filter-first") { Order::FilterFirst } else { Order::RescaleFirst };
}

fn edge(config: &Config) -> Option<Value> {
    Some(Value::word(match config.edge {
        Edge::G1 { .. } => "g1",
        Edge::G2 => "g2",
        Edge::G2Mod { .. } => "g2mod",
    }))
}

fn set_edge(config: &mut Config, value: Value) {
    config.edge = match (value.word, config.edge) {
        (Some("g1"), given @ Edge::G1 { .. }) | (Some("g2mod"), given @ Edge::G2Mod { .. }) => given,
        (Some("g1"), _) => Edge::G1 { p: 5000.0 },
        (Some("g2mod"), _) => Edge::G2Mod { c2: 0.8 },
        _ => Edge::G2,
    };
}

fn set_scheme(config: &mut Config, value: Value) {
    if let Some(scheme) = Scheme::ALL.into_iter().find(|scheme| value.is(scheme.name())) {
        *config = config.with_scheme(scheme);
    }
}

fn curvature_form(config: &Config) -> Option<Value> {
    Some(Value::word(match config.curvature_form {
        CurvatureForm::Consistent => "consistent",
        CurvatureForm::Printed => "printed",
    }))
}

fn set_curvature_form(config: &mut Config, value: Value) {
    config.curvature_form = if value.is("printed") { CurvatureForm::Printed } else { CurvatureForm::Consistent };
}

fn directions(config: &Config) -> Option<Value> {
    Some(Value::word(if config.directions == 64 { "64" } else { "16" }))
}

fn set_directions(config: &mut Config, value: Value) {
    config.directions = if value.is("64") { 64 } else { 16 };
}

fn start(config: &Config) -> Option<Value> {
    Some(Value::word(match config.start {
        Start::Frame => "frame",
        Start::Threshold { .. } => "threshold",
        Start::Given => "map",
    }))
}

fn set_start(config: &mut Config, value: Value) {
    config.start = match (value.word, config.start) {
        (Some("threshold"), given @ Start::Threshold { .. }) => given,
        (Some("threshold"), _) => Start::Threshold { margin: 4.0 },
        (Some("map"), _) => Start::Given,
        _ => Start::Frame,
    };
}

fn motion(config: &Config) -> Option<Value> {
    Some(Value::word(match config.motion {
        Motion::Inward => "inward",
        Motion::Outward => "outward",
    }))
}

fn set_motion(config: &mut Config, value: Value) {
    config.motion = if value.is("outward") { Motion::Outward } else { Motion::Inward };
}

fn band(config: &Config) -> Option<Value> {
    Some(config.band.map_or(Value::word("none"), |band| Value::of(Numbers::One(band))))
}

fn set_band(config: &mut Config, value: Value) {
    config.band = if let Numbers::One(band) = value.numbers { Some(band) } else { None };
}

fn stop(config: &Config) -> Option<Value> {
    Some(Value::word(match config.stop {
        Stop::Paper => "paper",
        Stop::Rate => "rate",
    }))
}

fn set_stop(config: &mut Config, value: Value) {
    config.stop = if value.is("rate") { Stop::Rate } else { Stop::Paper };
}

fn separate(config: &Config) -> Option<Value> {
    Some(Value::word(match config.separate {
        Separate::Tree => "tree",
        Separate::Components => "components",
    }))
}

fn set_separate(config: &mut Config, value: Value) {
    config.separate = if value.is("tree") { Separate::Tree } else { Separate::Components };
}

fn select(config: &Config) -> Option<Value> {
    Some(Value::word(match config.select {
        Select::Significance => "significance",
        Select::Area => "area",
    }))
}

fn set_select(config: &mut Config, value: Value) {
    config.select = if value.is("significance") { Select::Significance } else { Select::Area };
}

fn connectivity(config: &Config) -> Option<Value> {
    Some(Value::word(match config.connectivity {
        Connectivity::Four => "4",
        Connectivity::Eight => "8",
    }))
}

fn set_connectivity(config: &mut Config, value: Value) {
    config.connectivity = if value.is("4") { Connectivity::Four } else { Connectivity::Eight };
}

const EVERY: Range = Range { least: End::Open, most: End::Open };

/// A parameter that is a number.
const fn real(name: &'static str, keyword: &'static str, field: fn(&mut Config) -> Option<Slot<'_>>) -> Parameter {
    parameter(name, keyword, Numbers::One(0.0), Access::Field(field))
}

/// A parameter that is a whole number.
const fn whole(name: &'static str, keyword: &'static str, field: fn(&mut Config) -> Option<Slot<'_>>) -> Parameter {
    parameter(name, keyword, Numbers::Whole(0), Access::Field(field))
}

/// A parameter that is one of some words, or has a form of its own.
const fn choice(
    name: &'static str,
    keyword: &'static str,
    words: &'static [Word],
    get: fn(&Config) -> Option<Value>,
    set: fn(&mut Config, Value),
) -> Parameter {
    Parameter { words, ..parameter(name, keyword, Numbers::None, Access::Choice { get, set }) }
}

const fn parameter(name: &'static str, keyword: &'static str, bare: Numbers, access: Access) -> Parameter {
    Parameter {
        name,
        keyword,
        step: Step::Sky,
        unit: "",
        help: "",
        common: false,
        words: &[],
        bare,
        needs: &[],
        bounds: Bounds::Fixed([EVERY; 2]),
        access,
    }
}

impl Parameter {
    const fn at(self, step: Step, needs: &'static [Need]) -> Parameter {
        Parameter { step, needs, ..self }
    }

    const fn common(self) -> Parameter {
        Parameter { common: true, ..self }
    }

    const fn unit(self, unit: &'static str) -> Parameter {
        Parameter { unit, ..self }
    }

    const fn numbers(self, bare: Numbers) -> Parameter {
        Parameter { bare, ..self }
    }

    const fn range(self, range: Range) -> Parameter {
        Parameter { bounds: Bounds::Fixed([range; 2]), ..self }
    }

    const fn ranges_by(self, ranges: fn(&Config) -> [Range; 2]) -> Parameter {
        Parameter { bounds: Bounds::By(ranges), ..self }
    }

    const fn help(self, help: &'static str) -> Parameter {
        Parameter { help, ..self }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::arithmetic::F32;
    use std::string::ToString;

    /// A run in which the parameter is at work, and its value there.
    fn at_work(parameter: &Parameter) -> (Config, Value) {
        let config = parameter.at_work(&Config::NOISE_AWARE);
        assert_eq!(parameter.unmet(&config), None, "{}", parameter.name);
        let value = parameter.get(&config).or_else(|| panic!("{} has no value", parameter.name));
        (config, value.unwrap())
    }

    fn with(parameter: &Parameter, mut config: Config, value: Value) -> Config {
        parameter.set(&mut config, value).unwrap();
        config
    }

    #[test]
    fn names_and_keywords_are_told_once_and_needs_come_first() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let (before, name) = (&PARAMETERS[..index], parameter.name);
            assert!(before.iter().all(|other| other.name != name && other.keyword != parameter.keyword), "{name}");
            assert!(parameter.keyword.len() <= 8 && parameter.keyword.starts_with("SF"), "{name}");
            assert!(
                before.last().is_none_or(|other| other.step <= parameter.step),
                "{name} stands among another step's"
            );
            assert!(parameter.help.ends_with(['.', ')']), "{name} has no sentence of help");
            for need in parameter.needs.iter().flat_map(Need::choices) {
                let other = Parameter::named(need.name).unwrap();
                let known = |word: &&str| other.words.iter().any(|known| known.name == *word);
                assert!(need.words.iter().all(known), "{name} needs {need:?}");
            }
        }
    }

    #[test]
    fn values_are_read_as_they_are_written() {
        for parameter in PARAMETERS {
            let (config, value) = at_work(parameter);
            assert_eq!(parameter.parse(&value.to_string()), Some(value), "{}", parameter.name);
            assert_eq!(with(parameter, config, value), config, "{}", parameter.name);
            for word in parameter.words {
                let value = Value { word: Some(word.name), numbers: word.numbers };
                assert_eq!(parameter.parse(&value.to_string()), Some(value), "{}", parameter.name);
                assert_eq!(parameter.parse(word.name), Some(value), "{}", parameter.name);
                assert_eq!(parameter.get(&with(parameter, config, value)), Some(value), "{}", parameter.name);
            }
            assert_eq!(parameter.parse("upwind"), None, "{}", parameter.name);
            assert_eq!(parameter.parse(""), None, "{}", parameter.name);
        }
    }

    #[test]
    fn every_value_counts_in_the_digest() {
        for parameter in PARAMETERS {
            let (config, value) = at_work(parameter);
            let numbers = match value.numbers {
                Numbers::None if parameter.bare == Numbers::One(0.0) => Numbers::One(5.0),
                Numbers::None => Numbers::None,
                Numbers::Whole(number) => Numbers::Whole(number + 1),
                Numbers::One(number) => Numbers::One(number * 0.75),
                Numbers::Two(one, other) => Numbers::Two(one, other * 0.75),
            };
            let other = match numbers {
                Numbers::None => Value::word(parameter.words.iter().find(|word| !value.is(word.name)).unwrap().name),
                numbers => Value::of(numbers),
            };
            let changed = with(parameter, config, other);
            assert_ne!(parameter.get(&changed), Some(value), "{} was not set", parameter.name);
            assert_ne!(changed.digest(), config.digest(), "{}", parameter.name);
        }
    }

    #[test]
    fn a_number_is_the_value_of_one_parameter_alone() {
        for parameter in PARAMETERS.iter().filter(|parameter| matches!(parameter.access, Access::Field(_))) {
            let (config, value) = at_work(parameter);
            let other = match value.numbers {
                Numbers::Whole(number) => Numbers::Whole(number + 1),
                Numbers::One(number) => Numbers::One(number + 0.125),
                numbers => numbers,
            };
            let changed = with(parameter, config, Value::of(other));
            let differ = PARAMETERS.iter().filter(|one| one.get(&changed) != one.get(&config));
            assert!(differ.map(|one| one.name).eq([parameter.name]), "{}", parameter.name);
        }
    }

    #[test]
    fn numbers_out_of_bounds_name_the_parameter_whatever_the_number() {
        let refused = |parameter: &Parameter, config: Config, numbers: Numbers, word: Option<&'static str>| {
            let mut config = config;
            let error = parameter.set(&mut config, Value { word, numbers }).and_then(|()| config.validate::<F32>());
            assert!(
                matches!(error, Err(Error::Parameter { name, .. }) if name == parameter.name),
                "{} of {numbers:?}: {error:?}",
                parameter.name
            );
        };
        for parameter in PARAMETERS {
            let (config, value) = at_work(parameter);
            let forms = parameter.words.iter().map(|word| (Some(word.name), word.numbers));
            for (word, form) in forms.chain([(None, parameter.bare)]) {
                for wrong in [f32::NAN, f32::NEG_INFINITY, f32::INFINITY, -1.0] {
                    match form {
                        Numbers::None => {}
                        Numbers::Whole(_) => refused(parameter, config, Numbers::Whole(4_000_000_000), word),
                        Numbers::One(_) => refused(parameter, config, Numbers::One(wrong), word),
                        Numbers::Two(one, other) => {
                            refused(parameter, config, Numbers::Two(wrong, other), word);
                            refused(parameter, config, Numbers::Two(one, wrong), word);
                        }
                    }
                }
            }
            let [range, _] = parameter.ranges(&config);
            let numbers = value.numbers != Numbers::None;
            assert!(!numbers || range.least != End::Open && !range.to_string().is_empty(), "{}", parameter.name);
        }
    }

    #[test]
    fn what_is_not_used_names_the_choice() {
        let unmet = |name: &str, config: &Config| Parameter::named(name).unwrap().unmet(config).map(|need| need.name);
        assert_eq!(unmet("alpha", &Config::NOISE_AWARE), Some("scheme"));
        assert_eq!(unmet("alpha", &Config::PAPER_F160), Some("rescale"));
        assert_eq!(unmet("alpha", &Config::PAPER_REAL), None);
        assert_eq!(unmet("threshold", &Config::PAPER_REAL), Some("sky"));
        assert_eq!(unmet("deblend-light", &Config::PAPER_REAL), Some("separate"));
        assert_eq!(unmet("min-light", &Config::PAPER_REAL), Some("select"));
        assert_eq!(unmet("edge", &Config::CHAN_VESE), Some("scheme"));
        for config in [Config::NOISE_AWARE, Config::PAPER_F160, Config::PAPER_REAL, Config::CHAN_VESE] {
            assert_eq!(unmet("min-area", &config), None);
            assert_eq!(unmet("connectivity", &config), None);
        }
    }
}
