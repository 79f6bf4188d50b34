//! The parameters that a command line gives: one option each, made from the core's table.

use crate::read::Place;
use crate::settings::{self, notes};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use skyfront_core::config::{Config, Numbers, PARAMETERS, Parameter, Value};

/// Parameters with the values they were given, in the order of the table.
#[derive(Clone, Debug, Default)]
pub struct Given(Vec<(&'static Parameter, Setting)>);

/// What a parameter is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A value of the table.
    Value(Value),
    /// The map that a front starts from.
    Map(Place),
}

impl Setting {
    /// Its value for the core.
    pub fn value(&self) -> Value {
        match self {
            Setting::Value(value) => *value,
            Setting::Map(_) => Value::word(MAP),
        }
    }
}

/// The parameter that may be given a file, and its word for that.
const START: &str = "start";
const MAP: &str = "map";

impl Given {
    /// What a parameter was given.
    pub fn get(&self, name: &str) -> Option<&Setting> {
        self.0.iter().find(|(parameter, _)| parameter.name == name).map(|(_, setting)| setting)
    }

    /// The same with one more, or with another value for it.
    pub fn with(&self, name: &str, value: Value) -> Given {
        let Some(added) = Parameter::named(name) else { return self.clone() };
        let rest = self.0.iter().filter(|(parameter, _)| parameter.name != name).cloned();
        let mut all: Vec<_> = rest.chain([(added, Setting::Value(value))]).collect();
        let place = |name: &str| PARAMETERS.iter().position(|parameter| parameter.name == name);
        all.sort_by_key(|(parameter, _)| place(parameter.name));
        Given(all)
    }

    /// `config` with what is given.
    ///
    /// # Errors
    /// As [`settings::apply`].
    pub fn apply(&self, config: Config) -> anyhow::Result<Config> {
        let given: Vec<_> = self.0.iter().map(|(parameter, setting)| (*parameter, setting.value())).collect();
        Ok(settings::apply(config, &given)?)
    }
}

impl Args for Given {
    fn augment_args(command: Command) -> Command {
        PARAMETERS.iter().fold(command, |command, parameter| command.arg(option(parameter)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let given = |parameter: &'static Parameter| {
            matches.get_one::<Setting>(parameter.name).map(|setting| (parameter, setting.clone()))
        };
        Ok(Given(PARAMETERS.iter().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The option of a parameter.
fn option(parameter: &'static Parameter) -> Arg {
    let first = parameter.help.split(". ").next().unwrap_or_default().trim_end_matches('.');
    let default = parameter.default().map(|value| format!(" [default: {value}]"));
    Arg::new(parameter.name)
        .long(parameter.name)
        .value_name(if parameter.name == START { "frame|threshold|FILE[HDU]".to_owned() } else { forms(parameter) })
        .value_parser(parser(parameter))
        .allow_negative_numbers(true)
        .help_heading(parameter.step.title())
        .hide_short_help(!parameter.common)
        .help(first.to_owned() + &default.unwrap_or_default())
        .long_help(long_help(parameter))
}

/// The forms of its values in the option's help.
fn forms(parameter: &Parameter) -> String {
    match (parameter.bare, parameter.unit) {
        (Numbers::One(_) | Numbers::Whole(_), "px") if parameter.words.is_empty() => "PX".to_owned(),
        _ => parameter.forms().to_string(),
    }
}

/// Everything about a parameter: what it is, its words, its bounds, its default, and what uses it.
fn long_help(parameter: &Parameter) -> String {
    let mut text = parameter.help.to_owned();
    if !lists_words(parameter) {
        for word in parameter.words.iter().filter(|word| !word.help.is_empty() && word.name != MAP) {
            text += &format!("\n- {}: {}", word.name, word.help);
        }
    }
    if parameter.name == START {
        text += "\n- FILE[HDU]: a map; outside its pixels that are not 0, or, if some are negative, from its \
                 values as front.fits holds them; or seeds, for --motion outward. FILE.csv: a table of places, with \
                 columns x and y, counted from 1, or ra and dec";
    }
    text + "\n[" + &notes(parameter).join("; ") + "]"
}

/// Whether its values are words alone, which the help lists by itself.
fn lists_words(parameter: &Parameter) -> bool {
    let alone = parameter.words.iter().all(|word| word.numbers == Numbers::None);
    parameter.bare == Numbers::None && alone && parameter.name != START
}

fn parser(parameter: &'static Parameter) -> ValueParser {
    let read = move |text: &str| {
        let wrong = || match (parameter.words, parameter.bare) {
            ([], Numbers::Two(..)) => "two numbers with a comma between them are wanted".to_owned(),
            ([], Numbers::Whole(_)) => "is not a whole number".to_owned(),
            ([], _) => "is not a number".to_owned(),
            _ => format!("is none of {}", parameter.forms()),
        };
        parameter.parse(text).map(Setting::Value).ok_or_else(wrong)
    };
    if parameter.name == START {
        let file = |text: &str| Ok::<_, String>(Setting::Map(Place::new(text)));
        return ValueParser::from(
            move |text: &str| if text == MAP { file(text) } else { read(text).or_else(|_| file(text)) },
        );
    }
    if lists_words(parameter) {
        let values = parameter.words.iter().map(|word| {
            let value = PossibleValue::new(word.name);
            if word.help.is_empty() { value } else { value.help(word.help) }
        });
        return PossibleValuesParser::new(values).try_map(move |text| read(&text)).into();
    }
    ValueParser::from(read)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Options;
    use clap::Parser;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    /// What a line amounts to, or its error in one line.
    fn config(line: &[impl AsRef<str>]) -> Result<Config, String> {
        let line = line.iter().map(AsRef::as_ref);
        let line = Line::try_parse_from(line).map_err(|error| error.to_string())?;
        line.options.config().map_err(|error| error.to_string())
    }

    #[test]
    fn every_parameter_is_refused_where_a_choice_leaves_it_unused() {
        for parameter in PARAMETERS {
            let given = format!("--{}={}", parameter.name, parameter.default().expect("a default"));
            for (index, need) in parameter.needs.iter().enumerate() {
                let choice = Parameter::named(need.name).expect("needs are parameters");
                let others = choice.words.iter().map(|word| word.name).filter(|word| !need.words.contains(word));
                for other in others.filter(|other| *other != MAP) {
                    // The needs before this one are met.
                    let met = parameter.needs[..index].iter().filter(|met| met.name != need.name);
                    let mut line: Vec<String> = met.map(|met| format!("--{}={}", met.name, met.words[0])).collect();
                    line.extend([given.clone(), format!("--{}={other}", need.name)]);
                    let message = config(&line).expect_err("an option that is not used");
                    let expected = format!("--{} is not used by --{} {other}; it needs --", parameter.name, need.name);
                    assert!(message.starts_with(&expected), "{line:?}: {message}");
                }
            }
        }
    }

    #[test]
    fn every_parameter_can_be_given_and_does_not_change_by_its_default() {
        for parameter in PARAMETERS {
            let mut line: Vec<String> =
                parameter.needs.iter().map(|need| format!("--{}={}", need.name, need.words[0])).collect();
            let without = config(&line);
            let value = parameter.default().expect("a default");
            line.push(format!("--{}={value}", parameter.name));
            let with = config(&line);
            assert_eq!(with, without, "{line:?}");
            assert!(with.is_ok(), "{with:?}");
        }
    }

    #[test]
    fn a_preset_that_uses_it_is_the_way_out() {
        let message = config(&["--tau", "otsu"]).expect_err("the default does not rescale");
        assert_eq!(
            message,
            "--tau is not used by --scheme region; it needs --scheme other than region, as --preset rsa has"
        );
        let message = config(&["--preset", "paper-f160", "--mu", "1"]).expect_err("for another scheme");
        assert!(message.ends_with("it needs --scheme chan-vese or multiphase, as --preset chan-vese has"), "{message}");
    }
}
