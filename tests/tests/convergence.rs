//! Order of convergence of the two first-order schemes, measured and kept as a table in the README.
//!
//! A circle of radius 2 grows at speed 1 until t = 1; u0 is the distance to it, so u = r - 3 for r > 1. The mean error
//! over 1.5 <= r <= 3.5 is taken on four grids. f32 rounds u by 1e-7 a step, far below the errors. To renew the table
//! run this test with `CONVERGENCE=write`.

use skyfront_core::config::{Config, Scheme};
use skyfront_tests::evolve::Front;
use std::fmt::Write;

const README: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md");
const BEGIN: &str = "<!-- convergence: made by tests/tests/convergence.rs -->\n";
const END: &str = "<!-- end of convergence -->";
const GRIDS: [usize; 4] = [51, 101, 201, 401];

/// The mean |u - (r - 3)| on a grid of n x n nodes over 10 x 10 units of length.
fn error(scheme: Scheme, n: usize) -> f64 {
    let dx = 10.0 / (n as f32 - 1.0);
    // 64 directions: with 16 the semi-Lagrangian minimum misses a normal by up to 2 % on any grid.
    let config = Config { dx, directions: 64, ..Config::PAPER_F160 }.with_scheme(scheme);
    let mut front = Front::new(config, n, n, |x, y| x.hypot(y) - 2.0);
    front.until(1.0);
    let middle = (n as f64 - 1.0) / 2.0;
    let errors = front.values.iter().enumerate().filter_map(|(at, &u)| {
        let r = ((at % n) as f64 - middle).hypot((at / n) as f64 - middle) * f64::from(dx);
        (1.5..=3.5).contains(&r).then(|| (f64::from(u) - (r - 3.0)).abs())
    });
    let (count, sum) = errors.fold((0.0, 0.0), |(count, sum), error| (count + 1.0, sum + error));
    sum / count
}

#[test]
fn both_first_order_schemes_converge_at_order_one() {
    let mut table = "| dx | FD error | order | SL error | order |\n|---|---|---|---|---|\n".to_owned();
    let mut before: Option<[f64; 2]> = None;
    for n in GRIDS {
        let errors = [Scheme::Fd, Scheme::Sl].map(|scheme| error(scheme, n));
        let orders = before.map(|old| [(old[0] / errors[0]).log2(), (old[1] / errors[1]).log2()]);
        let order = |k: usize| orders.map_or("".to_owned(), |orders| format!("{:.2}", orders[k]));
        let dx = 10.0 / (n as f64 - 1.0);
        writeln!(table, "| {dx} | {:.4} | {} | {:.4} | {} |", errors[0], order(0), errors[1], order(1))
            .expect("text takes every line");
        // Where the grid is halved the error must be, but for the next term of the expansion.
        for order in orders.into_iter().flatten() {
            assert!((0.75..1.3).contains(&order), "order {order} at dx = {dx}\n{table}");
        }
        before = Some(errors);
    }
    println!("{table}");
    let readme = std::fs::read_to_string(README).expect("README.md");
    let (head, rest) = readme.split_once(BEGIN).expect("the place of the table in README.md");
    let (kept, tail) = rest.split_once(END).expect("the end of the table in README.md");
    if std::env::var("CONVERGENCE").as_deref() == Ok("write") {
        std::fs::write(README, format!("{head}{BEGIN}{table}{END}{tail}")).expect("README.md can be written");
    } else {
        assert_eq!(kept, table, "the table in README.md");
    }
}
