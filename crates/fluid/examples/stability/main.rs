//! Writes the stability table: `cargo run --release -p fluid --example stability -- docs/fluid/stability.md`.

mod cases;

use std::collections::BTreeMap;
use std::fmt::Write;

use cases::{Case, LOG_LINEAR, Outcome, channel, hard_scenes, outcome};
use scene::Scene;

const C_ETA: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
const REYNOLDS: [f64; 5] = [1.0, 20.0, 100.0, 1e3, 1e4];
const CFL: [f64; 4] = [0.1, 0.25, 0.4, 1.0];

/// Communication steps of 0.01 s in a run.
const STEPS: usize = 200;

const HEAD: &str = "# Stability of the fluid

Written by `cargo run --release -p fluid --example stability -- docs/fluid/stability.md`.

The cylinder in a channel of Schäfer and Turek on 200 x 40 points, density 1, mean inflow 1 m/s that starts by a jump at
t = 0, up to t = 2 s, in steps of at most 0.01 s and the given CFL number. Each cell: the largest speed at the end in m/s where
the run went through with everything finite (the peak of the inflow is 1.5 m/s), **wild** with that speed where it is 10 m/s or
more, or the letter of the error, below. CFL numbers above the limit of the scheme (docs/fluid.md) are there to be refused; where a
run went through in spite of that, its speed tells how little it is worth.
";

/// Error messages by their letters.
#[derive(Default)]
struct Errors {
    letters: BTreeMap<String, char>,
}

impl Errors {
    fn cell(&mut self, scene: &Scene, counts: &mut [usize; 4]) -> String {
        match outcome(scene, STEPS) {
            Outcome::Ok { fastest } => {
                counts[0] += 1;
                format!("{fastest:.1}")
            }
            Outcome::Wild { fastest } => {
                counts[1] += 1;
                format!("**wild** {fastest:.0}")
            }
            Outcome::NotFinite => {
                counts[2] += 1;
                "**NOT FINITE**".into()
            }
            Outcome::Error(message) => {
                counts[3] += 1;
                // One letter for each kind of message, with the numbers of its first case.
                let kind =
                    message.split_once(" at t =").or(message.split_once(" is too small")).map_or(&*message, |s| s.0);
                let kind: String = kind.chars().filter(|c| c.is_alphabetic() || *c == ' ').collect();
                let known = self.letters.iter().find(|(text, _)| text.starts_with(&kind)).map(|(_, letter)| *letter);
                let next = char::from(b'A' + self.letters.len() as u8);
                let letter = known.unwrap_or_else(|| {
                    self.letters.insert(format!("{kind}\u{0}{message}"), next);
                    next
                });
                let time = message.split_once("t = ").and_then(|(_, rest)| rest.split(' ').next()).unwrap_or("");
                format!("{letter} at {:.2} s", time.parse().unwrap_or(0.0))
            }
        }
    }
}

fn main() {
    let path = std::env::args().nth(1).expect("the file to write");
    let (mut text, mut errors, mut counts) = (String::from(HEAD), Errors::default(), [0; 4]);
    let mut table = |text: &mut String, title: &str, scheme, mask, c_eta: &[f64], reynolds: &[f64], cfl: &[f64]| {
        write!(text, "\n## {title}\n\n| Re | CFL |").expect("a string takes all");
        c_eta.iter().for_each(|c_eta| write!(text, " C_eta {c_eta:.0e} |").expect("a string takes all"));
        write!(text, "\n|---|---|{}", "---|".repeat(c_eta.len())).expect("a string takes all");
        for &reynolds in reynolds {
            for &cfl in cfl {
                write!(text, "\n| {reynolds} | {cfl} |").expect("a string takes all");
                for &c_eta in c_eta {
                    let case = Case { scheme, mask, c_eta, cfl, reynolds };
                    write!(text, " {} |", errors.cell(&channel(case), &mut counts)).expect("a string takes all");
                }
                eprintln!("{title}: Re {reynolds}, CFL {cfl}");
            }
        }
        text.push('\n');
    };
    table(&mut text, "Backward differences, log-linear mask", "sbdf2", LOG_LINEAR, &C_ETA, &REYNOLDS, &CFL);
    let others = [1e-2, 1e-4, 1e-8];
    let (sharp, cosine) = (("sharp", ""), ("cosine", r#", "half_width": 1.0"#));
    table(&mut text, "Backward differences, sharp mask", "sbdf2", sharp, &others, &[1.0, 100.0, 1e4], &[0.25, 1.0]);
    table(&mut text, "Backward differences, cosine mask", "sbdf2", cosine, &others, &[1.0, 100.0, 1e4], &[0.25, 1.0]);
    let explicit = [1e-2, 1e-3, 1e-8];
    table(&mut text, "Heun's method, sharp mask", "rk2", sharp, &explicit, &[1.0, 100.0, 1e4], &[0.25, 1.0]);
    text.push_str("\n## Hard scenes\n\nThe same channel, log-linear mask, C_eta 1e-5 s, CFL 0.4.\n\n| scene | Re 20 | Re 1e4 |\n|---|---|---|\n");
    let hard = [20.0, 1e4]
        .map(|reynolds| hard_scenes(Case { scheme: "sbdf2", mask: LOG_LINEAR, c_eta: 1e-5, cfl: 0.4, reynolds }));
    for ((name, low), (_, high)) in hard[0].iter().zip(&hard[1]) {
        let cells = [low, high].map(|scene| errors.cell(scene, &mut counts));
        writeln!(text, "| {name} | {} | {} |", cells[0], cells[1]).expect("a string takes all");
        eprintln!("{name}");
    }
    let [ok, wild, not_finite, refused] = counts;
    write!(
        text,
        "\n{ok} runs went through, {refused} ended in an error, {wild} went wild, {not_finite} were not finite.\n"
    )
    .expect("a string takes all");
    let mut letters: Vec<_> = errors.letters.iter().map(|(text, letter)| (letter, text)).collect();
    letters.sort();
    for (letter, message) in letters {
        let message = message.split_once('\u{0}').map_or("", |(_, message)| message);
        write!(text, "\n{letter} (first case): {message}\n").expect("a string takes all");
    }
    let unfinished = format!("{path}.new");
    std::fs::write(&unfinished, text).and_then(|()| std::fs::rename(&unfinished, &path)).expect("a writable path");
}
