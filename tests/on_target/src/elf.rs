//! What an image needs in flash, memory and stack, read from its file.
//!
//! The images keep their relocations and the compiler's stack sizes. Every relocation from one function
//! to another is an edge of the call graph; function pointers in constants (but not jump tables, which
//! point into functions) count as called by every function that refers to constants. The worst stack is the heaviest path from the start.

use anyhow::{Context, Result, bail};
use object::read::{Object, ObjectSection, ObjectSymbol, RelocationTarget};
use object::{Architecture, Endianness, SectionIndex, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The needs of one image, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Code and constants, without the start-up and its vector table.
    pub flash: u64,
    /// Variables, without the stack.
    pub memory: u64,
    /// The heaviest path of the call graph; `None` where it cannot be told, which is printed.
    pub stack: Option<u64>,
}

/// Reads an image.
///
/// # Errors
/// When it is no such image.
pub fn needs(image: &Path) -> Result<Needs> {
    let data = std::fs::read(image).with_context(|| image.display().to_string())?;
    let file = object::File::parse(&*data)?;
    let size = |name: &str| file.section_by_name(name).map_or(0, |section| section.size());
    let calls = Calls::read(&file).with_context(|| image.display().to_string())?;
    let start = calls.named("application").context("the image has no application")?;
    let stack = calls.worst(start, &mut BTreeMap::new(), &mut Vec::new());
    // Calls through pointers can feign a circle.
    let stack = stack.inspect_err(|reason| println!("{}: no stack by call graph: {reason}", image.display())).ok();
    Ok(Needs { flash: size(".text") + size(".rodata"), memory: size(".bss"), stack })
}

/// Counted for a function whose stack the compiler does not tell: the few routines of its runtime that are
/// written in assembly take at most 24 bytes.
const ASSEMBLY: u64 = 32;

/// A function's first address.
type Address = u64;

struct Function {
    name: String,
    end: Address,
    /// `None`: the compiler did not tell.
    stack: Option<u64>,
    calls: BTreeSet<Address>,
}

/// The call graph.
struct Calls(BTreeMap<Address, Function>);

impl Calls {
    fn read(file: &object::File<'_>) -> Result<Calls> {
        // The lowest bit of an address says "Thumb", not where.
        let clean = |address: u64| if file.architecture() == Architecture::Arm { address & !1 } else { address };
        let stacks: BTreeMap<Address, u64> =
            stack_sizes(file)?.into_iter().map(|(address, size)| (clean(address), size)).collect();
        let functions = file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
        let mut calls = Calls(
            functions
                .map(|symbol| {
                    let start = clean(symbol.address());
                    let name = symbol.name().unwrap_or("?").to_owned();
                    let stack = stacks.get(&start).copied();
                    (start, Function { name, end: start + symbol.size(), stack, calls: BTreeSet::new() })
                })
                .collect(),
        );
        let targets = |section: &object::Section<'_, '_>| -> Vec<(Address, Option<SectionIndex>, Address)> {
            section
                .relocations()
                .filter_map(|(at, relocation)| {
                    let RelocationTarget::Symbol(index) = relocation.target() else { return None };
                    let symbol = file.symbol_by_index(index).ok()?;
                    let addend = if symbol.kind() == SymbolKind::Section { relocation.addend() } else { 0 };
                    Some((at, symbol.section_index(), clean(symbol.address().wrapping_add_signed(addend))))
                })
                .collect()
        };
        let constants = file.section_by_name(".rodata");
        let pointers: Vec<Address> =
            constants.iter().flat_map(&targets).map(|(_, _, to)| to).filter(|to| calls.0.contains_key(to)).collect();
        let constants = constants.map(|section| section.index());
        for (at, section, to) in file.section_by_name(".text").iter().flat_map(&targets) {
            let Some(caller) = calls.at(at) else { continue };
            let called =
                if section.is_some() && section == constants { pointers.clone() } else { Vec::from_iter(calls.at(to)) };
            if let Some(function) = calls.0.get_mut(&caller) {
                function.calls.extend(called.into_iter().filter(|&to| to != caller));
            }
        }
        Ok(calls)
    }

    /// The function that an address lies in.
    fn at(&self, address: Address) -> Option<Address> {
        let (&start, function) = self.0.range(..=address).next_back()?;
        (address < function.end).then_some(start)
    }

    fn named(&self, name: &str) -> Option<Address> {
        self.0.iter().find(|(_, function)| function.name == name).map(|(&start, _)| start)
    }

    /// The heaviest path from `start`; `path` leads to it, `known` holds finished functions.
    fn worst(&self, start: Address, known: &mut BTreeMap<Address, u64>, path: &mut Vec<Address>) -> Result<u64> {
        if let Some(&stack) = known.get(&start) {
            return Ok(stack);
        }
        let function = self.0.get(&start).context("a call leads to no function")?;
        if path.contains(&start) {
            bail!("{} calls itself in a circle", function.name);
        }
        let own = function.stack.unwrap_or(ASSEMBLY);
        path.push(start);
        let mut below = 0;
        for &called in &function.calls {
            below = below.max(self.worst(called, known, path)?);
        }
        path.pop();
        known.insert(start, own + below);
        Ok(own + below)
    }
}

/// The compiler's table: an address of four bytes and an LEB128 number for each function.
fn stack_sizes(file: &object::File<'_>) -> Result<Vec<(Address, u64)>> {
    let section = file.section_by_name(".stack_sizes").context("no stack sizes")?;
    let mut data = section.data()?;
    let mut sizes = Vec::new();
    while let Some((address, rest)) = data.split_first_chunk::<4>() {
        let address = match file.endianness() {
            Endianness::Little => u32::from_le_bytes(*address),
            Endianness::Big => u32::from_be_bytes(*address),
        };
        let length = rest.iter().position(|byte| byte & 0x80 == 0).context("a stack size without end")? + 1;
        let (number, rest) = rest.split_at(length);
        let size = number.iter().rev().fold(0, |size, byte| (size << 7) | u64::from(byte & 0x7F));
        sizes.push((u64::from(address), size));
        data = rest;
    }
    Ok(sizes)
}
