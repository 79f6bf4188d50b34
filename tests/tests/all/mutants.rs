//! Damaged files: thousands of mutants of the specimens through the command line, a seed each.

use skyfront_tests::command::{Folder, messages, program};
use skyfront_tests::specimens::{self, Expect, Specimen};
use std::fs;
use std::process::Command;
use std::time::Instant;

/// Mutants: few by default, the twenty thousand of a full check with `SKYFRONT_MUTANTS=20000`.
fn mutants() -> u64 {
    std::env::var("SKYFRONT_MUTANTS").map_or(400, |text| text.parse().expect("SKYFRONT_MUTANTS is a number"))
}

/// Images of one run.
const BATCH: u64 = 200;
/// What a run may take, and what the program takes beside it.
const LIMIT: u64 = 40_000_000;
const PROGRAM: u64 = 20_000_000;

/// A generator of numbers below a bound (xorshift).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }
}

/// Damages a file as disks, networks and careless programs do, once to four times.
fn damage(bytes: &mut Vec<u8>, seed: u64) {
    let mut numbers = Numbers(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    for _ in 0..=numbers.below(4) {
        let at = numbers.below(bytes.len());
        match numbers.below(7) {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << numbers.below(8)),
            1 => bytes.truncate(at),
            2 => drop(bytes.splice(at..at, vec![b' '; 1 + numbers.below(100)])),
            3 => drop(bytes.drain(at..(at + 80).min(bytes.len()))),
            // The numbers of headers: any digit, or a sign.
            4 | 5 => {
                let digits: Vec<usize> = (0..bytes.len().min(8640)).filter(|&n| bytes[n].is_ascii_digit()).collect();
                if let Some(&digit) = digits.get(numbers.below(digits.len())) {
                    bytes[digit] = b"0123456789-."[numbers.below(12)];
                }
            }
            _ => {
                let value = numbers.below(256) as u8;
                bytes.iter_mut().skip(at).take(1 + numbers.below(64)).for_each(|byte| *byte = value);
            }
        }
        if bytes.is_empty() {
            return;
        }
    }
}

#[test]
fn no_mutant_crashes_hangs_or_takes_more_memory_than_told() {
    let folder = Folder::new("mutants");
    let sound = |specimen: &Specimen| matches!(specimen.expect, Expect::Pixels(..));
    let specimens: Vec<Specimen> = specimens::all().into_iter().filter(sound).collect();
    let limit = LIMIT.to_string();
    let (mut read, mut refused, mut longest, mut peak) = (0, 0, 0.0, 0);
    for first in (0..mutants()).step_by(BATCH as usize) {
        let files: Vec<String> = (first..(first + BATCH).min(mutants()))
            .map(|seed| {
                let mut bytes = specimens[seed as usize % specimens.len()].bytes.clone();
                damage(&mut bytes, seed);
                let path = folder.file(&format!("m{seed}"));
                fs::write(&path, bytes).expect("a mutant can be written");
                path
            })
            .collect();
        let started = Instant::now();
        let preset: &[&str] =
            if (first / BATCH).is_multiple_of(2) { &[] } else { &["--preset", "paper-f160", "--t-max", "0.5"] };
        let out = folder.file("out");
        let options = ["segment", "--quiet", "--no-pictures", "--json", "--max-memory", &limit];
        // A hang is ended by the system, after two minutes of the processor.
        let mut line = Command::new("sh");
        line.args(["-c", "ulimit -t 120; exec \"$0\" \"$@\""]).arg(program()).args(options).args(preset);
        let (output, kilobytes) = crate::habits::watched_command(line.args(["--out", &out]).args(&files));
        let text = messages(&output);
        assert!(matches!(output.status.code(), Some(0 | 1)), "seeds from {first}: {:?}: {text}", output.status);
        let results = String::from_utf8(output.stdout).expect("text");
        let failed = results.lines().filter(|line| line.contains("\"error\":")).count();
        assert_eq!((results.lines().count(), text.lines().count()), (files.len(), failed), "from {first}: {text}");
        assert!(!text.contains("internal error"), "seeds from {first}: {text}");
        (read, refused) = (read + files.len() - failed, refused + failed);
        longest = f64::max(longest, started.elapsed().as_secs_f64());
        peak = std::cmp::max(peak, 1000 * kilobytes);
        fs::remove_dir_all(&out).expect("the results can be removed");
        files.iter().for_each(|file| fs::remove_file(file).expect("a mutant can be removed"));
    }
    println!("{read} read, {refused} refused, longest {BATCH} {longest:.1} s, peak {peak} bytes");
    assert!(read > 0 && refused > 0);
    assert!(peak < LIMIT + PROGRAM, "{peak} bytes");
}
