use saltus::diagnosis::*;
fn main() {
    let folder: Vec<std::path::PathBuf> = std::env::args().skip(1).map(Into::into).collect();
    let f = saltus::experiment::read_all(&folder, &|_| ()).unwrap();
    let robot = f.robot.as_ref().map(|r| saltus::resolve(r, &[]).unwrap());
    let kind = kinds::build(&f.experiment, robot.as_ref()).unwrap();
    let d = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).unwrap();
    for c in &d.tried {
        println!("{} {:?} loss {} terms {:?} unknowns {:?}", kind.causes()[c.cause].id, kind.causes()[c.cause].column, c.fit.loss, c.fit.terms.of(c.cause), &c.fit.unknowns[..2.min(c.fit.unknowns.len())]);
        if kind.logs().len() < 3 { for run in 0..kind.logs().len() {
            let p = kind.predict(run, &c.fit.terms, &c.fit.unknowns[run]).unwrap();
            let r: Vec<String> = kind.logs()[run].readings.iter().zip(&p).step_by(4).map(|(a,b)| format!("{:.2}", a.value-b)).collect();
            println!("   {}", r.join(" "));
        }}
    }
}
