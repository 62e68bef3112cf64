//! Writes the stability table: `stability FILE.csv`.

#[path = "../../../tests/common/cases.rs"]
mod cases;

use cases::{Case, LOG_LINEAR, Outcome, channel, hard_scenes, outcome};
use scene::Scene;

const C_ETA: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
const REYNOLDS: [f64; 5] = [1.0, 20.0, 100.0, 1e3, 1e4];
/// Up to the limit of the two-step scheme, and beyond.
const CFL: [f64; 4] = [0.1, 0.25, 0.4, 1.0];
/// The same for Heun's method.
const CFL_RK2: [f64; 4] = [0.1, 0.25, 0.6, 1.0];

/// Communication steps of 0.01 s in a run.
const STEPS: usize = 200;

/// A line of the file.
fn line(group: &str, scene: &str, case: Case, run: Result<Scene, String>) -> String {
    let (outcome, speed, time, message) = match outcome(run, STEPS) {
        Outcome::Ok { fastest } => ("ok", Some(fastest), None, String::new()),
        Outcome::Wild { fastest } => ("bad", Some(fastest), None, "too fast for a flow".into()),
        Outcome::NotFinite => ("bad", None, None, "not finite".into()),
        Outcome::Error { time, message } => ("error", None, time, message.replace('"', "'")),
    };
    let [speed, time] = [speed, time].map(|number| number.map(|n| format!("{n:.6}")).unwrap_or_default());
    let Case { reynolds, cfl, c_eta, .. } = case;
    let line = format!(r#""{group}","{scene}",{reynolds},{cfl},{c_eta:e},{outcome},{speed},{time},"{message}""#) + "\n";
    eprint!("{line}");
    line
}

fn main() {
    let path = std::env::args().nth(1).expect("the file to write");
    let mut text = String::from("group,scene,reynolds,cfl,c_eta,outcome,speed,time,message\n");
    let (others, some, few) = ([1e-2, 1e-4, 1e-8], [1.0, 100.0, 1e4], [0.25, 0.4, 1.0]);
    let (sharp, cosine) = (("sharp", ""), ("cosine", r#", "half_width": 1.0"#));
    let groups: [(&str, &str, (&str, &str), &[f64], &[f64], &[f64]); 4] = [
        ("Backward differences, log-linear mask", "sbdf2", LOG_LINEAR, &C_ETA, &REYNOLDS, &CFL),
        ("Backward differences, sharp mask", "sbdf2", sharp, &others, &some, &few),
        ("Backward differences, cosine mask", "sbdf2", cosine, &others, &some, &few),
        ("Heun's method, sharp mask", "rk2", sharp, &[1e-2, 1e-3, 1e-8], &REYNOLDS, &CFL_RK2),
    ];
    for (group, scheme, mask, c_etas, numbers, cfls) in groups {
        let cases = numbers.iter().flat_map(|reynolds| cfls.iter().map(move |cfl| (*reynolds, *cfl)));
        for ((reynolds, cfl), c_eta) in cases.flat_map(|case| c_etas.iter().map(move |c_eta| (case, *c_eta))) {
            let case = Case { scheme, mask, c_eta, cfl, reynolds };
            text += &line(group, "", case, channel(case));
        }
    }
    for reynolds in [20.0, 1e4] {
        let case = Case { scheme: "sbdf2", mask: LOG_LINEAR, c_eta: 1e-5, cfl: 0.4, reynolds };
        for (name, scene) in hard_scenes(case).expect("they are scenes") {
            text += &line("Hard scenes", name, case, Ok(scene));
        }
    }
    std::fs::write(&path, text).expect("a writable path");
}
