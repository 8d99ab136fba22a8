//! Plots: SVG is well-formed, PNG is not blank.

use crate::common::Folder;

const PLOTS: [(&str, &str); 8] = [
    ("family", "simulate --omega 5 --alpha-f -0.25:0.05:7"),
    (
        "stall",
        "simulate --omega 0.1 --alpha-f 0 --start-lean -0.5",
    ),
    ("angles", "table --omega 3:6:7 --distance 0.4:0.7:4"),
    ("law", "law --omega 3:6:5 --distance 0.7"),
    ("laws", "law --omega 3:6:5 --distance 0.5,0.7"),
    ("scene", "plan box.toml"),
    ("sheet", "verify box.toml --samples 5 --friction 0.5,1"),
    ("map", "map --omega 2:7:11 --alpha-f -0.5:0.5:9"),
];

const BOX: &str = "\
approach_rate_rad_s = 5
target_x_m = 0.9
[[obstacle]]
front_x_m = 0.4
width_m = 0.05
height_m = 0.1
[[avoid]]
from_x_m = 0.5
to_x_m = 0.7
";

/// A folder with the courses.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("box.toml", BOX);
    folder
}

#[test]
fn an_svg_is_well_formed_and_says_what_it_shows() {
    let folder = folder("svg");
    for (name, line) in PLOTS {
        folder.done(&format!("{line} --plot {name}.svg"), 0);
        let text = folder.read(&format!("{name}.svg"));
        check_well_formed(&text);
        assert!(
            text.contains("rats-planar") && text.contains("<text"),
            "{name}"
        );
        assert!(
            text.matches("<circle").count()
                + text.matches("<poly").count()
                + text.matches("<rect").count()
                > 8
        );
    }
    assert!(
        folder.read("family.svg").contains("−0.15") && folder.read("family.svg").contains("x (m)")
    );
    assert!(folder.read("map.svg").contains("early-lift-off"));
}

/// Every element is closed in its turn, and there is one root.
fn check_well_formed(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut roots = 0;
    for part in text.split('<').skip(1) {
        let (tag, _) = part.split_once('>').expect("a tag ends");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/', '\n'])
            .next()
            .unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.starts_with(['?', '!']) {
            roots += usize::from(open.is_empty());
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
    }
    assert_eq!((open.len(), roots), (0, 1));
}

#[test]
fn a_png_decodes_and_is_not_blank() {
    let folder = folder("png");
    for (name, line) in PLOTS {
        folder.done(&format!("{line} --plot {name}.png"), 0);
        let file = std::fs::File::open(folder.path(&format!("{name}.png"))).unwrap();
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert!(info.width >= 1000 && info.height >= 600, "{name}");
        let dark = pixels
            .chunks(3)
            .filter(|pixel| pixel.iter().all(|byte| *byte < 100))
            .count();
        let white = pixels
            .chunks(3)
            .filter(|pixel| pixel.iter().all(|byte| *byte == 255))
            .count();
        // Text and axes are dark; the margins are white.
        assert!(dark > 2000 && white > 100_000, "{name}: {dark} {white}");
    }
}

#[test]
fn plots_are_the_same_on_every_run() {
    let folder = Folder::new("same");
    for end in ["svg", "png"] {
        for name in ["a", "b"] {
            folder.done(
                &format!("simulate --omega 5 --alpha-f 0 --plot {name}.{end}"),
                0,
            );
        }
        let bytes = |name: &str| std::fs::read(folder.path(&format!("{name}.{end}"))).unwrap();
        assert!(bytes("a") == bytes("b"), "{end}");
    }
}
