//! `skyfront man` and `skyfront completions`, both made from the definitions of the options.

use super::say::{Stderr, Stdout};
use crate::write::Products;
use anyhow::{Context, Result};
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct ManArguments {
    /// The command to describe [default: skyfront itself].
    command: Option<String>,
    /// Write the pages of all commands into this folder instead; made where it is absent, earlier pages are
    /// replaced. `~/.local/share/man/man1` is where `man` looks.
    #[arg(long, short, value_name = "FOLDER", conflicts_with = "command")]
    out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

/// Prints a manual page, or writes all of them.
pub fn man(arguments: &ManArguments) -> Result<()> {
    let mut program = super::command();
    program.build();
    match &arguments.out {
        Some(folder) => install(program, folder),
        None => {
            let page = page(&program, arguments.command.as_deref())?;
            write!(Stdout, "{}", String::from_utf8_lossy(&page))?;
            Ok(())
        }
    }
}

/// A page of a command, or of the program.
fn page(program: &Command, name: Option<&str>) -> Result<Vec<u8>> {
    let command = match name {
        None => program.clone(),
        Some(name) => program
            .find_subcommand(name)
            .with_context(|| format!("there is no command '{name}'; `skyfront --help` lists them"))?
            .clone()
            .display_name(format!("skyfront-{name}")),
    };
    let mut text = Vec::new();
    Man::new(command).render(&mut text)?;
    Ok(text)
}

/// Writes the pages of all commands.
fn install(program: Command, folder: &Path) -> Result<()> {
    let commands = program.get_subcommands().map(Command::get_name).filter(|name| *name != "help");
    let names: Vec<Option<&str>> = std::iter::once(None).chain(commands.map(Some)).collect();
    let file = |name: &Option<&str>| name.map_or("skyfront.1".to_owned(), |name| format!("skyfront-{name}.1"));
    let files: Vec<String> = names.iter().map(file).collect();
    let mut products = Products::plan(folder, &files.iter().map(String::as_str).collect::<Vec<_>>(), true)?;
    for (name, file) in names.iter().zip(&files) {
        let text = page(&program, *name)?;
        products.write(file, |out| out.write_all(&text))?;
    }
    let written = products.publish()?;
    writeln!(Stderr, "{} manual pages in {}", written.len(), folder.display());
    Ok(())
}

/// Prints completions.
pub fn completions(arguments: &CompletionsArguments) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut super::command(), "skyfront", &mut text);
    write!(Stdout, "{}", String::from_utf8_lossy(&text))?;
    Ok(())
}
