//! The multibody plant beside Pinocchio and MuJoCo: one process, interleaved, thread time, and
//! instructions under callgrind. `run` beside this file installs the peers and starts it; README.md
//! says what is compared.
//!
//! `cargo bench -p twinhub-plant --bench peers -- [--peers FOLDER] [--json FILE] [--tree FILE]`.

mod library;
mod mapping;
mod measure;
mod mujoco;
mod report;
mod rows;
mod tree;

use report::Answer;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Default)]
struct Arguments {
    peers: Option<PathBuf>,
    json: Option<PathBuf>,
    tree: Option<PathBuf>,
    repeat: Option<(String, usize)>,
}

fn arguments() -> Result<Arguments, String> {
    let mut a = Arguments::default();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut next = || words.next().ok_or(format!("{word} wants a value"));
        match word.as_str() {
            "--peers" => a.peers = Some(next()?.into()),
            "--json" => a.json = Some(next()?.into()),
            "--tree" => a.tree = Some(next()?.into()),
            "--repeat" => {
                let name = next()?;
                let count = next()?
                    .parse()
                    .map_err(|_| "--repeat wants NAME COUNT".to_owned())?;
                a.repeat = Some((name, count));
            }
            // What cargo itself passes.
            "--bench" => {}
            other => {
                return Err(format!(
                    "`{other}`; accepted: --peers FOLDER, --json FILE, --tree FILE, --repeat NAME COUNT"
                ));
            }
        }
    }
    Ok(a)
}

fn main() -> ExitCode {
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!("peers: {why}");
            return ExitCode::from(2);
        }
    };
    let parameters = rows::parameters();
    if let Some(file) = &arguments.tree {
        let text = format!("{:#}\n", tree::json(&parameters));
        if let Err(e) = std::fs::write(file, text) {
            eprintln!("peers: cannot write {}: {e}", file.display());
            return ExitCode::from(2);
        }
    }
    let bench = rows::Bench::new(
        &parameters,
        arguments.peers.as_deref(),
        arguments.repeat.is_none(),
    );
    if let Some((name, count)) = &arguments.repeat {
        let Some(row) = bench.rows.iter().find(|row| row.name == name) else {
            eprintln!("peers: no row called {name}");
            return ExitCode::from(2);
        };
        (row.run)(*count);
        return ExitCode::SUCCESS;
    }
    let mut costs = measure::times(&bench.rows);
    if measure::valgrind_is_there() {
        let more: Vec<String> = arguments
            .peers
            .iter()
            .flat_map(|folder| ["--peers".to_owned(), folder.display().to_string()])
            .collect();
        for (row, cost) in bench.rows.iter().zip(&mut costs) {
            match measure::instructions(row.name, row.results, &more) {
                Ok(n) => cost.instructions = Some(n),
                Err(why) => eprintln!("peers: {}: {why}", row.name),
            }
        }
    } else {
        eprintln!("peers: instructions are not counted: valgrind is missing");
    }
    let answer = Answer::new(&bench, &costs);
    answer.print();
    if let Some(file) = &arguments.json
        && let Err(e) = std::fs::write(file, format!("{:#}\n", answer.json()))
    {
        eprintln!("peers: cannot write {}: {e}", file.display());
        return ExitCode::from(2);
    }
    if answer.all_met() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    }
}
