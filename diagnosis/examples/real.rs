//! Scratch: real data through the diagnosis.
use saltus_diagnosis::kinds::{flight::Flights, slide, stroke::{Drive, Strokes}, vessel::{Vessel, Vessels}};
use saltus_diagnosis::{Channel, Kind, Log, Reading, Settings, diagnose};

fn csv(path: &str) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(str::to_owned).collect();
    (names, lines.map(|l| l.split(',').map(|c| c.parse().ok()).collect()).collect())
}
fn files(dir: &str) -> Vec<String> {
    let mut v: Vec<String> = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path().display().to_string()).filter(|p| p.ends_with(".csv")).collect();
    v.sort();
    v
}
fn log(path: &str, channels: &[Channel]) -> Log {
    let (names, rows) = csv(path);
    let mut readings = Vec::new();
    for row in &rows {
        for (k, c) in channels.iter().enumerate() {
            if let Some(i) = names.iter().position(|n| n == c.name) {
                if let Some(v) = row[i] { readings.push(Reading { channel: k, time: row[0].unwrap(), value: v }); }
            }
        }
    }
    Log { name: path.into(), readings }
}
fn show(name: &str, kind: &dyn Kind) {
    let t = std::time::Instant::now();
    let Some(d) = diagnose(kind, &Settings::default()) else { println!("{name}: no answer"); return };
    println!("== {name}  ({:.1} s) inflation {:.1} unknown {} loss {:.0} -> {:.0}", t.elapsed().as_secs_f64(), d.inflation, d.unknown, d.before.loss, d.after.loss);
    for f in &d.findings {
        let c = &kind.causes()[f.cause];
        print!("   {}", c.id);
        for cand in &f.candidates {
            let c = &kind.causes()[cand.cause];
            let vals: Vec<String> = c.parameters.iter().enumerate().map(|(i, p)| format!("{}={:.4e}", p.name, cand.fit.terms.get(cand.cause, i))).collect();
            print!(" | {} gain {:.1} held {:.1} {}", c.id, cand.gain, cand.held_out, vals.join(" "));
        }
        println!();
    }
    for c in &d.tried { println!("      tried {:18} loss {:.0}", kind.causes()[c.cause].id, c.fit.loss); }
    println!("   errors {:?} singular {:?}", d.after.errors, d.after.singular);
    for (c, (a, b)) in kind.channels().iter().zip(&d.held_out) { println!("   {} held-out rms {a:.4e} -> {b:.4e} noise {:.2e}", c.name, c.noise); }
}
fn main() {
    let root = std::env::args().nth(1).unwrap();
    let which = std::env::args().nth(2).unwrap_or_default();
    if which.is_empty() || which == "ball" {
    for e in std::fs::read_dir(format!("{root}/ball-drops")).unwrap() {
        let dir = e.unwrap().path().display().to_string();
        let ch = vec![Channel { name: "y_m", noise: 0.04 }];
        let logs = files(&dir).iter().map(|f| log(f, &ch)).collect();
        show(&dir, &Flights::new(9.80665, ch, logs, false));
    } }
    if which.is_empty() || which == "hop" {
    for e in std::fs::read_dir(format!("{root}/hopper-flights")).unwrap() {
        let dir = e.unwrap().path().display().to_string();
        let ch = vec![Channel { name: "x_m", noise: 5e-4 }, Channel { name: "y_m", noise: 5e-4 }];
        let logs = files(&dir).iter().map(|f| log(f, &ch)).collect();
        show(&dir, &Flights::new(9.80665, ch, logs, true));
    } }
    if which.is_empty() || which == "stroke" {
    for (seal, bore) in [("napn", 0.025), ("o-ring257", 0.0257)] {
        let dir = format!("{root}/piston-seals/{seal}");
        let ch = Channel { name: "force_n", noise: 0.06 };
        let logs: Vec<Log> = files(&dir).iter().map(|f| log(f, &[ch.clone()])).collect();
        let drives = files(&dir).iter().map(|f| { let (n, r) = csv(f); let col = |s: &str| { let i = n.iter().position(|x| x == s).unwrap(); r.iter().map(|r| r[i].unwrap()).collect() };
            Drive { bore, position: col("position_m"), pressure: col("pressure_gauge_pa") } }).collect();
        show(&dir, &Strokes::new(ch, logs, drives));
    } }
    if which.is_empty() || which == "vessel" {
    let ch = vec![Channel { name: "pressure_pa", noise: 3000.0 }, Channel { name: "temperature_k", noise: 1.0 }];
    let logs = vec![log(&format!("{root}/vessel-discharge/discharge.csv"), &ch)];
    show("vessel", &Vessels::new(ch, logs, vec![Vessel { volume: 0.01618, orifice: 0.00271, pressure: 790000.0, temperature: 298.0, ambient: 100000.0, wall: Some(0.3864) }]));
    }
    let _ = slide::Drive { mass: None, time: vec![], force: vec![] };
}
