//! Writes the stability table, of runs over 200 communication steps of 0.01 s: `stability FILE.csv`.

#[path = "../../../../../crates/fluid/tests/common/cases.rs"]
mod cases;

use cases::{Case, LOG_LINEAR, Outcome, channel, hard_scenes, outcome};
use scene::Scene;

fn main() -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(std::env::args().nth(1).expect("the file to write"))?;
    file.write_record(["group", "scene", "reynolds", "cfl", "c_eta", "outcome", "speed", "time", "message"])?;
    let mut run = |group: &str, name: &str, case: Case, scene: Result<Scene, String>| {
        let (outcome, speed, time, message) = match outcome(scene, 200) {
            Outcome::Ok { fastest } => ("ok", Some(fastest), None, String::new()),
            Outcome::Wild { fastest } => ("bad", Some(fastest), None, "too fast for a flow".into()),
            Outcome::NotFinite => ("bad", None, None, "not finite".into()),
            Outcome::Error { time, message } => ("error", None, time, message.replace('"', "'")),
        };
        let [speed, time] = [speed, time].map(|number| number.map(|n| format!("{n:.6}")));
        let row = (group, name, case.reynolds, case.cfl, case.c_eta, outcome, speed, time, message);
        eprintln!("{row:?}");
        file.serialize(row)
    };
    let mut channels = |group, scheme, mask, c_etas: &[f64], numbers: &[f64], cfls: &[f64]| {
        for reynolds in numbers.iter().copied() {
            for (cfl, c_eta) in cfls.iter().flat_map(|cfl| c_etas.iter().map(|c_eta| (*cfl, *c_eta))) {
                let case = Case { scheme, mask, c_eta, cfl, reynolds };
                run(group, "", case, channel(case))?;
            }
        }
        Ok::<_, csv::Error>(())
    };
    let (c_etas, numbers) = ([1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8], [1.0, 20.0, 100.0, 1e3, 1e4]);
    // Up to the limit of each scheme, and beyond.
    let (cfls, cfls_rk2) = ([0.1, 0.25, 0.4, 1.0], [0.1, 0.25, 0.6, 1.0]);
    let (others, some, few) = ([1e-2, 1e-4, 1e-8], [1.0, 100.0, 1e4], [0.25, 0.4, 1.0]);
    let (sharp, cosine) = (("sharp", ""), ("cosine", r#", "half_width": 1.0"#));
    channels("Backward differences, log-linear mask", "sbdf2", LOG_LINEAR, &c_etas, &numbers, &cfls)?;
    channels("Backward differences, sharp mask", "sbdf2", sharp, &others, &some, &few)?;
    channels("Backward differences, cosine mask", "sbdf2", cosine, &others, &some, &few)?;
    channels("Heun's method, sharp mask", "rk2", sharp, &[1e-2, 1e-3, 1e-8], &numbers, &cfls_rk2)?;
    for reynolds in [20.0, 1e4] {
        let case = Case { scheme: "sbdf2", mask: LOG_LINEAR, c_eta: 1e-5, cfl: 0.4, reynolds };
        for (name, scene) in hard_scenes(case).expect("they are scenes") {
            run("Hard scenes", name, case, Ok(scene))?;
        }
    }
    Ok(file.flush()?)
}
