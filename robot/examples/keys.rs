//! Prints the page of keys that `robots/README.md` shows.

fn main() {
    print!("{}", saltus_robot::terms::page());
}
