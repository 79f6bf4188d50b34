//! Instructions in double precision, which many flight processors' units do not have: none may be in an image in single.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// Comes with the compiler for C.
const DISASSEMBLER: &str = "arm-none-eabi-objdump";

/// Looks through an image for the Cortex-M7, whose unit has both precisions.
///
/// # Errors
/// Names the functions with such instructions, or what the disassembler said.
pub fn none_in(image: &Path) -> Result<()> {
    let mut command = Command::new(DISASSEMBLER);
    let output = command.args(["--disassemble", "--demangle"]).arg(image).output();
    let output = output.with_context(|| format!("cannot start {DISASSEMBLER}"))?;
    let listing = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() || !listing.contains(SINGLE) {
        bail!("{DISASSEMBLER} lists no program: {}", String::from_utf8_lossy(&output.stderr));
    }
    let found = functions_with_doubles(&listing);
    if !found.is_empty() {
        bail!("double precision in {}: {}", image.display(), found.join(", "));
    }
    Ok(())
}

/// What ends the names of instructions in single precision.
const SINGLE: &str = ".f32";
/// What the names of those in double precision have, conversions too.
const DOUBLE: &str = ".f64";

/// The functions of a listing that have instructions in double precision, in their order.
fn functions_with_doubles(listing: &str) -> Vec<&str> {
    let (mut function, mut found) = ("?", Vec::new());
    for line in listing.lines() {
        if let Some((_, name)) = line.strip_suffix(">:").and_then(|line| line.split_once('<')) {
            function = name;
        } else if line.contains(DOUBLE) && found.last() != Some(&function) {
            found.push(function);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTING: &str = "\
size_f32_fd:     file format elf32-littlearm

00000100 <<core::Histogram>::otsu>:
     100:\tee71 0a20 \tvadd.f32\ts1, s2, s1
00000104 <<core::Histogram>::kapur>:
     104:\tee30 0b04 \tvadd.f64\td0, d0, d4
     108:\teeb7 0ac0 \tvcvt.f64.f32\td0, s0
0000010c <pass>:
     10c:\ted2d 8b02 \tvpush\t{d8}
00000110 <narrow>:
     110:\teeb7 0bc0 \tvcvt.f32.f64\ts0, d0
";

    #[test]
    fn functions_with_double_precision_are_named() {
        assert_eq!(functions_with_doubles(LISTING), ["<core::Histogram>::kapur", "narrow"]);
    }
}
