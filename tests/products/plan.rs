//! Plans are data: they can be checked for any number of processes without running anything.

use catamaran::kernel::int8::IntegerIsa;
use catamaran::product::{Node, Task, thread_levels};
use catamaran::{Accuracy, AtaOptions, Par, Plan, SchemeChoice};

/// Equation 8.6 as printed, `P / 2` in integers.
fn equation_8_6(p: usize) -> usize {
    match p {
        1 => 0,
        2 | 3 => 1,
        _ => {
            let half = p / 2;
            let k = (0..).take_while(|&k| half >= 4_usize.pow(k)).last().unwrap();
            1 + k as usize + usize::from(!half.is_multiple_of(4_usize.pow(k.max(1))))
        }
    }
}

#[test]
fn levels_of_the_task_tree_are_those_of_equation_8_6() {
    for p in 1..=64 {
        assert_eq!(thread_levels(p), equation_8_6(p), "P = {p}");
        assert_eq!(Node::symmetric(4096, p).depth(), equation_8_6(p), "P = {p}");
    }
}

/// How often each entry is owned, and by how many tasks each process is served.
fn ownership(n: usize, k: usize, tasks: &[Task]) -> Vec<usize> {
    let mut owners = vec![0; n * k];
    for task in tasks {
        for i in task.rows.clone() {
            for j in task.cols.clone() {
                owners[i * k + j] += usize::from(!task.triangle || i >= j);
            }
        }
    }
    owners
}

#[test]
fn leaves_own_every_entry_of_the_lower_triangle_once() {
    for p in 1..=64 {
        for n in [0, 1, 2, 3, 31, 100] {
            let owners = ownership(n, n, &Node::symmetric(n, p).tasks());
            for i in 0..n {
                for j in 0..n {
                    assert_eq!(owners[i * n + j], usize::from(i >= j), "P = {p}, n = {n}");
                }
            }
        }
    }
}

#[test]
fn leaves_own_every_entry_of_a_general_product_once() {
    for p in 1..=64 {
        for (n, k) in [(0, 4), (1, 1), (5, 64), (64, 5), (33, 47)] {
            let owners = ownership(n, k, &Node::general(n, k, p).tasks());
            assert!(owners.iter().all(|&o| o == 1), "P = {p}, {n} x {k}");
        }
    }
}

#[test]
fn every_process_has_work_and_no_number_is_left_out() {
    for p in 1..=64 {
        let mut seen: Vec<_> = Node::symmetric(4096, p).tasks().iter().map(|t| t.process).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen, (0..p).collect::<Vec<_>>(), "P = {p}");
    }
}

#[test]
fn half_of_the_processes_work_below_the_diagonal() {
    for p in [4, 8, 16, 32, 64] {
        let Node::Inner(children) = Node::symmetric(4096, p) else { panic!("one leaf") };
        let mut below: Vec<_> =
            children.last().unwrap().tasks().iter().map(|t| t.process).collect();
        below.dedup();
        assert_eq!(below.len(), p / 2, "P = {p}");
    }
}

#[test]
fn a_complete_level_balances_the_work() {
    for p in [2, 4, 16] {
        let mut work = vec![0; p];
        for t in Node::symmetric(4096, p).tasks() {
            let area = t.rows.len() * t.cols.len();
            work[t.process] += if t.triangle { area } else { 2 * area };
        }
        assert!(work.iter().all(|&w| w == work[0]), "P = {p}: {work:?}");
    }
}

#[test]
fn a_plan_does_not_depend_on_the_number_of_threads() {
    for (m, n) in [(500, 500), (8192, 8192), (1_000_000, 100), (30_000, 2_500)] {
        let plan = |par| {
            let options = AtaOptions::new().par(par);
            Plan::ata::<f64>(m, n, &options).unwrap()
        };
        for threads in [1, 2, 7, 64] {
            assert_eq!(plan(Par::Threads(threads)), plan(Par::Seq), "{m} x {n}");
        }
    }
}

#[test]
fn small_products_are_classical_and_classical_accuracy_always_is() {
    let options = AtaOptions::default();
    assert!(!Plan::ata::<f64>(100, 100, &options).unwrap().is_fast());
    let options = AtaOptions::new().accuracy(Accuracy::Classical);
    assert!(!Plan::ata::<f64>(20_000, 20_000, &options).unwrap().is_fast());
}

#[test]
fn large_products_are_fast() {
    let options = AtaOptions::default();
    // With AMX the exact path is faster still.
    let fast =
        |plan: Plan| plan.is_fast() || IntegerIsa::best() == IntegerIsa::Amx && plan.is_exact();
    assert!(fast(Plan::ata::<f64>(16_384, 16_384, &options).unwrap()));
    assert!(fast(Plan::atb::<f32>(16_384, 16_384, 16_384, &options).unwrap()));
}

#[test]
fn a_printed_plan_names_scheme_tasks_and_scratch() {
    let check = |scheme, words: &[&str]| {
        let options = AtaOptions::new().scheme(scheme);
        let text = Plan::ata::<f64>(4096, 4096, &options).unwrap().to_string();
        for word in ["4096 x 4096", "f64", "estimate"].iter().chain(words) {
            assert!(text.contains(word), "{word} not in:\n{text}");
        }
    };
    check(SchemeChoice::Rxtx, &["rxtx", "winograd", "tasks", "scratch"]);
    check(SchemeChoice::Kgp4, &["kgp", "strassen", "products", "fused"]);
}

#[test]
fn the_faithful_mode_is_fast_only_where_blocks_stay_long() {
    let options = AtaOptions::new().scheme(SchemeChoice::Ata2);
    let fast = |m, n| Plan::ata::<f64>(m, n, &options).unwrap().is_fast();
    for (m, n, expected) in [
        (1_000_000, 100, false),
        (60_000, 500, false),
        (100, 8192, false),
        (4096, 4096, false),
        (8192, 8192, true),
        (16_384, 8192, true),
    ] {
        assert_eq!(fast(m, n), expected, "{m} x {n}");
    }
    let deeper = options.clone().leaf(256);
    assert!(Plan::ata::<f64>(4096, 4096, &deeper).unwrap().is_fast());
    // A^T B has no diagonal blocks, and its first level is cut by no task.
    let general = |n| Plan::atb::<f64>(n, n, n, &options).unwrap().is_fast();
    assert_eq!([3000, 4096, 8192].map(general), [false, true, true]);
}

#[test]
fn levels_of_ata_d_are_those_of_equation_8_5_and_messages_those_of_proposition_8_3() {
    use catamaran::ranks::plan::{TaskTree, proposition_8_3, rank_levels};
    // Equation 8.5 by hand; P / 4 is 1, 7, 8, 9, 16 and 64 for P from 7 on.
    let expected = [(1, 0), (2, 1), (6, 1), (7, 2), (31, 2), (32, 2), (36, 3), (64, 2), (256, 3)];
    for (ranks, depth) in expected {
        assert_eq!(rank_levels(ranks), depth, "P = {ranks}");
        assert_eq!(TaskTree::new(1024, 1024, ranks).depth(), depth, "P = {ranks}");
    }
    // All levels are complete, except at P = 64.
    for (ranks, equal) in [(1, true), (6, true), (32, true), (256, true), (64, false)] {
        let load = TaskTree::new(1024, 1024, ranks).loads()[0];
        let planned = (load.messages_sent + load.messages_received) as f64;
        assert_eq!(planned == proposition_8_3(ranks, 1024, 1024).0, equal, "P = {ranks}");
    }
}
