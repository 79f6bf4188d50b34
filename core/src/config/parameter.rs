//! What a parameter is: its name, its values and their bounds, and the choices that use it.

use super::Config;
use crate::arithmetic::digest::Digest;
use crate::error::Error;
use core::fmt;

/// A step of a run, in the order of the steps: parameters are listed by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Sky and noise, and what stands out of them.
    Sky,
    /// Pixel values become numbers in [0, 1].
    Normalize,
    /// Intensities are rescaled.
    Rescale,
    /// Noise is smoothed away.
    Filter,
    /// The speed of the front.
    Speed,
    /// The front, from its start to its end.
    Front,
    /// What was outlined becomes sources.
    Separate,
    /// Which sources are kept.
    Select,
}

impl Step {
    /// Its heading in a list of parameters.
    pub const fn title(self) -> &'static str {
        match self {
            Step::Sky => "Sky and threshold",
            Step::Normalize => "Normalisation",
            Step::Rescale => "Rescaling",
            Step::Filter => "Filter",
            Step::Speed => "Edge detector",
            Step::Front => "Front",
            Step::Separate => "Separation of sources",
            Step::Select => "Selection of sources",
        }
    }
}

/// The numbers of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// None: the word says it all.
    None,
    /// A whole number.
    Whole(u32),
    /// A number.
    One(f32),
    /// Two numbers, as `3,30`.
    Two(f32, f32),
}

/// The value of a parameter: a word, numbers, or a word with numbers, as `noise:3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// One of the parameter's words.
    pub word: Option<&'static str>,
    /// Its numbers.
    pub numbers: Numbers,
}

impl Value {
    /// A word alone.
    pub const fn word(word: &'static str) -> Value {
        Value { word: Some(word), numbers: Numbers::None }
    }

    /// Numbers alone.
    pub const fn of(numbers: Numbers) -> Value {
        Value { word: None, numbers }
    }

    /// Whether its word is this one.
    pub fn is(&self, word: &str) -> bool {
        self.word == Some(word)
    }
}

impl fmt::Display for Value {
    /// As it is written on a command line; numbers in the fewest digits that give the same bits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word.unwrap_or_default())?;
        if self.word.is_some() && self.numbers != Numbers::None {
            f.write_str(":")?;
        }
        match self.numbers {
            Numbers::None => Ok(()),
            Numbers::Whole(number) => write!(f, "{number}"),
            Numbers::One(number) => write!(f, "{number}"),
            Numbers::Two(first, second) => write!(f, "{first},{second}"),
        }
    }
}

/// A word that a parameter may be given.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// The numbers that follow it, with their defaults.
    pub numbers: Numbers,
    /// What it means; empty where the word says it.
    pub help: &'static str,
}

/// A word without numbers.
pub(super) const fn word(name: &'static str, help: &'static str) -> Word {
    Word { name, numbers: Numbers::None, help }
}

/// A choice that a parameter needs in order to be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// The parameter that makes the choice.
    pub name: &'static str,
    /// The words that use it.
    pub words: &'static [&'static str],
    /// Another choice that uses it as well.
    pub or: Option<&'static Need>,
}

impl Need {
    pub(super) const fn of(name: &'static str, words: &'static [&'static str]) -> Need {
        Need { name, words, or: None }
    }

    pub(super) const fn or(self, other: &'static Need) -> Need {
        Need { or: Some(other), ..self }
    }

    /// It, and the others of which each is enough.
    pub fn choices(&self) -> impl Iterator<Item = &Need> {
        core::iter::successors(Some(self), |need| need.or)
    }
}

/// An end of a range. Comparisons with it are written so that a NaN fails them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// None.
    Open,
    /// The number itself belongs to the range.
    At(f32),
    /// The number itself does not.
    Beyond(f32),
    /// The number, and what rounding makes of a value that should equal it.
    About(f32),
}

/// Rounding slack of [`End::About`]: the paper's own values meet their bounds with equality.
const SLACK: f32 = 1.000_001;

/// The numbers that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The lower end.
    pub least: End,
    /// The upper end.
    pub most: End,
}

impl Range {
    /// From one number to another, both included.
    pub const fn within(least: f32, most: f32) -> Range {
        Range { least: End::At(least), most: End::At(most) }
    }

    /// Above one number, up to another.
    pub const fn above(least: f32, most: End) -> Range {
        Range { least: End::Beyond(least), most }
    }

    #[inline(always)]
    fn check(&self, name: &'static str, value: f32) -> Result<(), Error> {
        let (enough, bound, limit) = match self.least {
            End::Open => (true, "", 0.0),
            End::At(limit) | End::About(limit) => (value >= limit, "at least", limit),
            End::Beyond(limit) => (value > limit, "above", limit),
        };
        if !enough {
            return Err(Error::Parameter { name, value, bound, limit });
        }
        let (within, bound, limit) = match self.most {
            End::Open => (true, "", 0.0),
            End::At(limit) => (value <= limit, "at most", limit),
            End::About(limit) => (value <= limit * SLACK, "at most", limit),
            End::Beyond(limit) => (value < limit, "below", limit),
        };
        if within { Ok(()) } else { Err(Error::Parameter { name, value, bound, limit }) }
    }
}

impl fmt::Display for Range {
    /// `0 to 1`, `above 0, below 1`; nothing where there are no ends.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.least, self.most) {
            (End::Open, End::Open) => return Ok(()),
            (End::At(least) | End::About(least), End::At(most) | End::About(most)) => {
                return write!(f, "{least} to {most}");
            }
            (End::At(least) | End::About(least), _) => write!(f, "at least {least}")?,
            (End::Beyond(least), _) => write!(f, "above {least}")?,
            (End::Open, _) => {}
        }
        let comma = if self.least == End::Open || self.most == End::Open { "" } else { ", " };
        match self.most {
            End::Open => Ok(()),
            End::At(most) | End::About(most) => write!(f, "{comma}at most {most}"),
            End::Beyond(most) => write!(f, "{comma}below {most}"),
        }
    }
}

/// The ranges of a parameter's numbers, the first and the second.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bounds {
    /// The same for every run.
    Fixed([Range; 2]),
    /// They depend on other parameters.
    By(fn(&Config) -> [Range; 2]),
}

/// Where a number stands in a configuration.
pub(super) enum Slot<'a> {
    Real(&'a mut f32),
    Short(&'a mut u16),
    Long(&'a mut u32),
}

/// How a parameter is read from a configuration, and written to it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Access {
    /// It is a field, where the configuration has it.
    Field(fn(&mut Config) -> Option<Slot<'_>>),
    /// It is a choice, or more than one field follows from it.
    Choice { get: fn(&Config) -> Option<Value>, set: fn(&mut Config, Value) },
}

/// A parameter of a run.
///
/// ```
/// use skyfront_core::config::{Config, Parameter};
///
/// let mut config = Config::NOISE_AWARE;
/// let threshold = Parameter::named("threshold").expect("it is in the table");
/// let value = threshold.parse("1.5").expect("a number");
/// threshold.set(&mut config, value)?;
/// assert_eq!(config.outline.threshold, 1.5);
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name, as an option (`--name`) and as a key of a configuration file.
    pub name: &'static str,
    /// Its keyword in FITS headers.
    pub keyword: &'static str,
    /// The step it belongs to.
    pub step: Step,
    /// The unit of its numbers; empty for pure numbers and words.
    pub unit: &'static str,
    /// What it is; the first sentence is enough for a short list.
    pub help: &'static str,
    /// Whether it is one of the few that most users want.
    pub common: bool,
    /// The words that it may be given.
    pub words: &'static [Word],
    /// The numbers that it may be given instead of a word.
    pub bare: Numbers,
    /// What it needs in order to be used, the choice that others depend on first.
    pub needs: &'static [Need],
    pub(super) bounds: Bounds,
    pub(super) access: Access,
}

impl Parameter {
    /// Its value in a configuration, where there is one.
    #[inline(always)]
    pub fn get(&self, config: &Config) -> Option<Value> {
        let field = match self.access {
            Access::Choice { get, .. } => return get(config),
            Access::Field(field) => field,
        };
        let mut config = *config;
        Some(Value::of(match field(&mut config)? {
            Slot::Real(number) => Numbers::One(*number),
            Slot::Short(number) => Numbers::Whole(u32::from(*number)),
            Slot::Long(number) => Numbers::Whole(*number),
        }))
    }

    /// Gives it a value; what a choice has not been told yet takes its defaults. Nothing happens
    /// where the configuration has no such value, or the value is of another kind. Set parameters
    /// in the order of [`PARAMETERS`](super::PARAMETERS), then validate the configuration.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a whole number out of bounds; others are checked with the whole.
    pub fn set(&self, config: &mut Config, value: Value) -> Result<(), Error> {
        if let Numbers::Whole(number) = value.numbers {
            let [range, _] = self.ranges(config);
            range.check(self.name, number as f32)?;
        }
        match self.access {
            Access::Choice { set, .. } => set(config, value),
            Access::Field(field) => match (field(config), value.numbers) {
                (Some(Slot::Real(slot)), Numbers::One(number)) => *slot = number,
                (Some(Slot::Short(slot)), Numbers::Whole(number)) => *slot = number as u16,
                (Some(Slot::Long(slot)), Numbers::Whole(number)) => *slot = number,
                _ => {}
            },
        }
        Ok(())
    }

    /// The ranges of its first and its second number in a configuration.
    #[inline(always)]
    pub fn ranges(&self, config: &Config) -> [Range; 2] {
        match self.bounds {
            Bounds::Fixed(ranges) => ranges,
            Bounds::By(ranges) => ranges(config),
        }
    }

    /// Checks its value in a configuration.
    #[inline(always)]
    pub(super) fn check(&self, config: &Config) -> Result<(), Error> {
        let Some(value) = self.get(config) else { return Ok(()) };
        let [first, second] = self.ranges(config);
        match value.numbers {
            Numbers::None => Ok(()),
            Numbers::Whole(number) => first.check(self.name, number as f32),
            Numbers::One(number) => first.check(self.name, number),
            Numbers::Two(one, other) => {
                first.check(self.name, one)?;
                second.check(self.name, other)
            }
        }
    }

    /// Feeds its value in a configuration to a digest.
    #[inline(always)]
    pub(super) fn feed(&self, config: &Config, digest: &mut Digest) {
        let Some(Value { word, numbers }) = self.get(config) else { return digest.bytes(&[0]) };
        digest.bytes(word.unwrap_or_default().as_bytes());
        let [first, second] = match numbers {
            Numbers::None => [0, 0],
            Numbers::Whole(number) => [number, 0],
            Numbers::One(number) => [number.to_bits(), 0],
            Numbers::Two(one, other) => [one.to_bits(), other.to_bits()],
        };
        digest.bytes(&[1]);
        digest.bytes(&first.to_le_bytes());
        digest.bytes(&second.to_le_bytes());
    }

    /// Reads a value, as [`Value`] writes it; `None` where it has no such form.
    pub fn parse(&self, text: &str) -> Option<Value> {
        let (name, rest) = text.split_once(':').map_or((text, None), |(name, rest)| (name, Some(rest)));
        let Some(word) = self.words.iter().find(|word| word.name == name) else {
            return numbers(self.bare, text).map(Value::of);
        };
        let numbers = match rest {
            None => Some(word.numbers),
            Some(rest) => numbers(word.numbers, rest),
        };
        numbers.map(|numbers| Value { word: Some(word.name), numbers })
    }

    /// The forms of its values: `otsu|kapur|rosin|noise[:X]|X`.
    pub fn forms(&self) -> Forms<'_> {
        Forms(self)
    }
}

/// Numbers of this kind from text.
fn numbers(kind: Numbers, text: &str) -> Option<Numbers> {
    let number = |text: &str| text.trim().parse().ok();
    match kind {
        Numbers::None => None,
        Numbers::Whole(_) => text.trim().parse().ok().map(Numbers::Whole),
        Numbers::One(_) => number(text).map(Numbers::One),
        Numbers::Two(..) => {
            let (first, second) = text.split_once(',')?;
            Some(Numbers::Two(number(first)?, number(second)?))
        }
    }
}

/// What [`Parameter::forms`] gives.
#[derive(Clone, Copy, Debug)]
pub struct Forms<'a>(&'a Parameter);

impl fmt::Display for Forms<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters = |numbers| match numbers {
            Numbers::None => "",
            Numbers::Whole(_) => "N",
            Numbers::One(_) => "X",
            Numbers::Two(..) => "LOW,HIGH",
        };
        let Forms(parameter) = self;
        for (index, word) in parameter.words.iter().enumerate() {
            write!(f, "{}{}", if index > 0 { "|" } else { "" }, word.name)?;
            if word.numbers != Numbers::None {
                write!(f, "[:{}]", letters(word.numbers))?;
            }
        }
        let between = !parameter.words.is_empty() && parameter.bare != Numbers::None;
        write!(f, "{}{}", if between { "|" } else { "" }, letters(parameter.bare))
    }
}
