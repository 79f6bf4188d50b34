//! `skyfront man` and `skyfront completions`, both made from the definitions of the options.

use super::Cli;
use super::say::Stdout;
use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

#[derive(Debug, Args)]
pub struct ManArguments {
    /// The command to describe [default: skyfront itself].
    command: Option<String>,
}

#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

/// Prints a manual page.
pub fn man(arguments: &ManArguments) -> Result<()> {
    let mut program = Cli::command();
    program.build();
    let page = match &arguments.command {
        None => program,
        Some(name) => program
            .find_subcommand(name)
            .with_context(|| format!("there is no command '{name}'; `skyfront --help` lists them"))?
            .clone()
            .display_name(format!("skyfront-{name}")),
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text)?;
    write!(Stdout, "{}", String::from_utf8_lossy(&text))?;
    Ok(())
}

/// Prints completions.
pub fn completions(arguments: &CompletionsArguments) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "skyfront", &mut text);
    write!(Stdout, "{}", String::from_utf8_lossy(&text))?;
    Ok(())
}
