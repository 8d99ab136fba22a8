//! Jumps of the whole robot as CSV: `jumps [ROBOT [LAUNCHES.csv]]`, where ROBOT is a built-in one
//! or a TOML file (default `rats-boom`).
//!
//! Launches have the columns `rate_rad_s,lean_rad,firing_angle_rad,valve_open_s`, under a header;
//! without a file a short list is flown.

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

use saltus_sim_check::{Launch, Outcome, Plan, Rig};

const LAUNCH: &str = "rate_rad_s,lean_rad,firing_angle_rad,valve_open_s";
const BUILT_IN: &str = "5,-0.3,-0.1,0.1\n4,-0.3,-0.2,0.04\n6,-0.3,0,0.1\n";
const REPORT: &str = "end,at_end_stop,fire_s,lift_off_s,lift_off_lean_rad,lift_off_rate_rad_s,lift_off_extension_m,lift_off_pressure_pa,lift_off_x_m,lift_off_z_m,lift_off_vx_m_s,lift_off_vz_m_s,apex_m,landing_m,landing_0_m,least_normal_n,friction_needed,slipped_m";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let robot =
        saltus_robot::resolve(&arguments.next().unwrap_or_else(|| "rats-boom".into()), &[])?;
    let launches = match arguments.next() {
        Some(file) => {
            let text =
                std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))?;
            parse(&text).map_err(|reason| format!("{file}: {reason}"))?
        }
        None => parse(&format!("{LAUNCH}\n{BUILT_IN}"))?,
    };
    let rig = Rig::new(&robot, &[])?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{LAUNCH},{REPORT}")?;
    for launch in &launches {
        writeln!(out, "{}", line(&rig, launch)?)?;
    }
    Ok(())
}

fn parse(text: &str) -> Result<Vec<Launch>, String> {
    let mut lines = text.lines();
    if lines.next().map(str::trim) != Some(LAUNCH) {
        return Err(format!("line 1: must be {LAUNCH}"));
    }
    let rows = lines
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    rows.map(|(i, line)| {
        let wrong = || format!("line {}: {line}: must be four numbers", i + 2);
        let row: Vec<f64> = line
            .split(',')
            .map(|cell| cell.trim().parse().map_err(|_| wrong()))
            .collect::<Result<_, _>>()?;
        let [rate, lean, firing_angle, valve_open] = row[..] else {
            return Err(wrong());
        };
        Ok(Launch {
            rate,
            lean,
            firing_angle,
            valve_open,
        })
    })
    .collect()
}

fn line(rig: &Rig, launch: &Launch) -> Result<String, Box<dyn Error>> {
    let report = rig.jump(launch, &Plan::default())?;
    let mut cells: Vec<String> = [
        launch.rate,
        launch.lean,
        launch.firing_angle,
        launch.valve_open,
    ]
    .map(|x| x.to_string())
    .into();
    cells.push(format!("{:?}", report.end));
    match report.lift_off {
        Some(l) => {
            cells.push((l.outcome == Outcome::Stroke).to_string());
            let numbers = [
                l.time_fire,
                l.time,
                l.lean,
                l.rate,
                l.extension,
                l.pressure,
                l.axle[0],
                l.axle[1],
                l.axle_rates[0],
                l.axle_rates[1],
            ];
            cells.extend(numbers.map(|x| x.to_string()));
        }
        None => cells.extend(vec![String::new(); 11]),
    }
    let rest = [
        report.apex,
        report.landing,
        report.landing_at,
        report.least_normal,
        report.friction_needed,
        report.slipped[0],
    ];
    cells.extend(rest.map(|x| x.to_string()));
    Ok(cells.join(","))
}
