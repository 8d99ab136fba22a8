//! Every model of a robot has the gas of its file.

use crate::common::Folder;

/// Carbon dioxide by its name and as its own values; and sulphur hexafluoride, which has no name.
const NAMED: &str = "--set leg.gas=co2";
const DESCRIBED: &str = "--set leg.gas={heat_ratio=1.289,molar_mass_kg_mol=0.0440095}";
const HEAVY: &str = "--set leg.gas={heat_ratio=1.094,constant_j_per_kg_k=56.93}";

/// A command for each model that has a gas, to which the gas is added.
const MODELS: &[&str] = &[
    "simulate --omega 5 --alpha-f -0.1",
    "simulate --omega 5 --alpha-f -0.1 --set leg.tube={length_m=0.5,diameter_mm=4}",
    "table --omega 5 --distance 0.6",
    "law --omega 4.5:5.5:3 --distance 0.6",
    "map --omega 4:5:2 --alpha-f -0.2:0:2",
    "plan course.toml",
    "verify --law=-0.1245,0.38 --distance 0.6 --omega 5 --samples 3 --plant rats-boom --plant-GAS",
    "filling --omega 4.5 --alpha-f -0.1 --set tank.volume_l=0.05",
    "run closed-loop --seconds 1",
    "run closed-loop --seconds 1 --exact --set tank.volume_l=0.5",
    "inject --kind bench --runs 3 --out data",
    "inject --kind jump --runs 1 --out data",
    "inject --kind run --robot rats-run --out data",
    "export c --distance 0.5:0.6:2 --omega 4.5:5.5:3 --out data",
];

/// What a command answers and writes for a robot with this gas.
fn answer(folder: &Folder, line: &str, gas: &str) -> String {
    let _ = std::fs::remove_dir_all(folder.path("data"));
    let line = match line.strip_suffix("--plant-GAS") {
        Some(line) => format!("{line} {}", gas.replace("--set", "--plant-set")),
        None => format!("{line} {gas}"),
    };
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = folder.run(&words);
    assert!(matches!(run.code, Some(0 | 1)), "{line}: {}", run.err);
    let mut answer = run.out;
    if line.contains("--out data") {
        for name in folder.names_in("data") {
            answer += &folder.read(&format!("data/{name}"));
        }
    }
    answer
}

#[test]
fn every_model_has_the_gas_of_the_robot_file() {
    let folder = Folder::new("gases");
    folder.write("course.toml", "approach_rate_rad_s = 5\ntarget_x_m = 0.6\n");
    for line in MODELS {
        let [named, described, heavy] =
            [NAMED, DESCRIBED, HEAVY].map(|gas| answer(&folder, line, gas));
        let air = answer(&folder, line, "--set leg.gas=air");
        assert_eq!(named, described, "{line}");
        for other in [&air, &heavy] {
            // The robot's file in the answer differs in any case.
            let numbers = |text: &str| {
                let is_gas =
                    |line: &&str| line.starts_with("heat_ratio") || line.starts_with("constant");
                let lines = text.lines().filter(|line| !is_gas(line));
                lines.map(str::to_owned).collect::<Vec<_>>()
            };
            assert_ne!(numbers(&named), numbers(other), "{line}");
        }
    }
}

/// A diagnosis and a fit believe in the gas of the robot file beside the data.
#[test]
fn a_diagnosis_has_the_gas_of_the_robot_file() {
    let folder = Folder::new("gases-diagnosed");
    folder.done(
        &format!("inject --kind bench --runs 4 --out data {HEAVY}"),
        0,
    );
    let nothing = folder.done("diagnose data --most 1", 0);
    assert!(nothing.contains("Nothing is wrong"), "{nothing}");
    let fit = |gas: &str| {
        let words = format!("fit data {gas}");
        let run = folder.run(&words.split_whitespace().collect::<Vec<_>>());
        format!("{:?} {}", run.code, run.out)
    };
    assert_ne!(fit(""), fit("--set leg.gas=air"));
    // Taken for air, they disagree.
    let robot = folder.read("data/robot.toml");
    let of_air = robot
        .replace("heat_ratio = 1.094", "heat_ratio = 1.4")
        .replace(
            "constant_j_per_kg_k = 56.93",
            "constant_j_per_kg_k = 287.05",
        );
    assert_ne!(robot, of_air);
    folder.write("data/robot.toml", of_air);
    folder.done("diagnose data --most 1", 1);
}

/// A leg without gas has no such key.
#[test]
fn a_leg_without_gas_takes_none() {
    let folder = Folder::new("gases-none");
    for robot in ["spring-hopper", "table-hopper", "rats-twelve"] {
        let words = format!("simulate --omega 5 --alpha-f -0.1 --robot {robot} {NAMED}");
        let run = folder.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{robot}");
        assert!(
            run.err.contains("--set leg.gas=co2: unknown key leg.gas"),
            "{}",
            run.err
        );
    }
}
