//! `twinhub list` and `twinhub explain`: what there is, and what it means.

use crate::exit::bad_input;
use crate::registries;
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use std::process::ExitCode;
use twinhub_plant::bicycles::{self, Bicycle, multibody_sets};
use twinhub_plant::disturbance::{self, DisturbanceModel as _};
use twinhub_plant::motor;
use twinhub_plant::multibody::{self, Parameters};
use twinhub_plant::rider::{Channel, Channels};
use twinhub_plant::{sensor, tyre};
use twinhub_sim::shipped;

/// Arguments of `twinhub list`.
#[derive(Args)]
pub struct ListArgs {
    /// One kind only, as printed by `twinhub list`.
    kind: Option<String>,
    /// The bicycle whose parameters are listed: a multibody set or plant file.
    #[arg(long, value_name = "NAME_OR_FILE", default_value = multibody_sets::FULL)]
    bicycle: String,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Arguments of `twinhub explain`.
#[derive(Args)]
pub struct ExplainArgs {
    /// A name that `twinhub list` prints.
    name: String,
}

/// A name and one sentence about it.
struct Entry {
    name: String,
    about: String,
}

fn entry(name: impl Into<String>, about: impl Into<String>) -> Entry {
    Entry {
        name: name.into(),
        about: about.into(),
    }
}

/// First line of a TOML text's `about`, or of its leading comment.
fn about(text: &str) -> String {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    match table.get("about").and_then(toml::Value::as_str) {
        Some(about) => about.to_owned(),
        None => {
            let comment: Vec<&str> = text
                .lines()
                .map_while(|line| line.strip_prefix('#'))
                .map(str::trim)
                .collect();
            comment.join(" ")
        }
    }
}

fn shipped_entries(files: &[shipped::Shipped]) -> Vec<Entry> {
    files
        .iter()
        .map(|file| entry(file.name, about(file.text)))
        .collect()
}

/// Symbols of linear bicycles, and paths of a multibody one with its values.
fn parameter_entries(bicycle: &Parameters) -> Vec<Entry> {
    let symbols = twinhub_linear::SYMBOLS
        .iter()
        .map(|symbol| entry(*symbol, twinhub_linear::unit(symbol).unwrap_or("")));
    let paths = bicycle.entries().into_iter().map(|e| {
        let meaning = multibody::meaning(&e.path).unwrap_or_default();
        let about = format!("{} {}: {meaning}", e.value, multibody::unit(&e.path));
        entry(e.path, about)
    });
    symbols.chain(paths).collect()
}

fn bicycle_entries() -> Vec<Entry> {
    bicycles::names()
        .into_iter()
        .map(|name| {
            let about = bicycles::describe(&name).unwrap_or_default();
            entry(name, about)
        })
        .collect()
}

/// Every kind with its entries.
fn catalogue(bicycle: &Parameters) -> Vec<(&'static str, Vec<Entry>)> {
    let pairs = |list: &[(&'static str, &'static str)]| -> Vec<Entry> {
        list.iter()
            .map(|(name, about)| entry(*name, *about))
            .collect()
    };
    let mut kinds = vec![
        ("courses", shipped_entries(shipped::COURSES)),
        ("riders", shipped_entries(shipped::RIDERS)),
        (
            "channels",
            Channel::NAMES
                .iter()
                .map(|name| entry(*name, Channels::explain(name).map_or("", |e| e.what)))
                .collect(),
        ),
        ("laws", shipped_entries(shipped::LAWS)),
        ("roads", shipped_entries(shipped::ROADS)),
        ("winds", shipped_entries(shipped::WINDS)),
        ("bicycles", bicycle_entries()),
        ("parameters", parameter_entries(bicycle)),
        (
            "tyres",
            tyre::SETS
                .iter()
                .map(|set| entry(set.name, set.about))
                .collect(),
        ),
        ("motors", pairs(motor::sets::SETS)),
        ("sensors", pairs(sensor::sets::SUITES)),
        (
            "disturbances",
            disturbance::sets::all()
                .iter()
                .map(|(name, about, _)| entry(*name, *about))
                .collect(),
        ),
        (
            "studies",
            twinhub_diagnose::study::shipped::NAMES
                .iter()
                .map(|name| entry(*name, "measured ride"))
                .collect(),
        ),
        (
            "mechanisms",
            twinhub_mechanism::ALL
                .iter()
                .map(|m| entry(m.card().name, m.card().claim))
                .collect(),
        ),
        (
            "health",
            twinhub_types::Health::TABLE
                .iter()
                .map(|h| entry(h.code, h.cause))
                .collect(),
        ),
        ("scenarios", shipped_entries(shipped::SCENARIOS)),
    ];
    kinds.extend(
        registries::kinds()
            .iter()
            .map(|(kind, entries)| (*kind, pairs(entries))),
    );
    kinds
}

/// Prints what there is.
///
/// # Errors
/// If there is no such kind.
pub fn list(args: &ListArgs) -> anyhow::Result<ExitCode> {
    let none: [&str; 0] = [];
    let bicycle = bicycles::load_multibody(&args.bicycle, &none).map_err(bad_input)?;
    let mut catalogue = catalogue(&bicycle);
    if let Some(kind) = &args.kind {
        let kinds: Vec<&str> = catalogue.iter().map(|(kind, _)| *kind).collect();
        if !kinds.contains(&kind.as_str()) {
            return Err(bad_input(anyhow!(
                "no kind `{kind}`; there are {}",
                kinds.join(", ")
            )));
        }
        catalogue.retain(|(k, _)| k == kind);
    }
    if args.json {
        let kinds: serde_json::Map<String, serde_json::Value> = catalogue
            .iter()
            .map(|(kind, entries)| {
                let entries: Vec<_> = entries
                    .iter()
                    .map(|e| json!({ "name": e.name, "about": e.about }))
                    .collect();
                ((*kind).to_owned(), json!(entries))
            })
            .collect();
        println!(
            "{}",
            serde_json::to_string_pretty(&json!({ "schema_version": 1, "kinds": kinds }))?
        );
        return Ok(ExitCode::SUCCESS);
    }
    for (kind, entries) in &catalogue {
        println!("{kind}");
        for e in entries {
            println!("  {:<24} {}", e.name, e.about);
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Everything that is known about `name`, from every registry that has it.
fn explanations(name: &str) -> Vec<String> {
    let mut texts = Vec::new();
    let files = [
        ("course", shipped::COURSES),
        ("rider", shipped::RIDERS),
        ("law", shipped::LAWS),
        ("scenario", shipped::SCENARIOS),
        ("road", shipped::ROADS),
        ("wind", shipped::WINDS),
    ];
    for (kind, table) in files {
        if let Some(file) = table.iter().find(|file| file.name == name) {
            texts.push(format!("{kind} {name}\n\n{}", file.text.trim_end()));
            if kind == "rider" {
                texts.extend(crate::rider::growth_in_words(name));
            }
        }
    }
    if let Some(set) = tyre::set(name) {
        texts.push(format!("tyre set {name}: {}\n{:#?}", set.about, set.tyre));
    }
    texts.extend(registries::explanations(name));
    texts.extend(Channels::explain(name).map(|e| format!("rider channel {e}")));
    texts.extend(motor::sets::named(name).map(|set| format!("motor set {name}\n{set:#?}")));
    texts.extend(sensor::sets::named(name).map(|set| format!("sensor suite {name}\n{set:#?}")));
    for (set, about, what) in disturbance::sets::all() {
        if set == name {
            texts.push(format!("{set}: {about}\n{}\n{what:#?}", what.explain()));
        }
    }
    texts.extend(bicycle_text(name));
    texts.extend(parameter_text(name));
    texts.extend(twinhub_mechanism::find(name).map(|m| m.card().to_string()));
    if let Some(h) = twinhub_types::Health::TABLE.iter().find(|h| h.code == name) {
        texts.push(format!(
            "health flag {name}\nCause: {}\nThe rider is told: {}\nClears: {}",
            h.cause, h.told, h.clears
        ));
    }
    texts
}

/// A bicycle with all its values.
fn bicycle_text(name: &str) -> Option<String> {
    let none: [&str; 0] = [];
    let about = bicycles::describe(name)?;
    let bicycle = bicycles::load(name, &none).ok()?;
    let mut text = format!("bicycle {name}: {about}\nSource: {}\n", bicycle.source());
    match &bicycle {
        Bicycle::Benchmark(bicycle) => {
            for remark in &bicycle.remarks {
                text += &format!("Note: {remark}\n");
            }
            for symbol in twinhub_linear::SYMBOLS {
                let value = bicycle.get(symbol).unwrap_or(f64::NAN);
                let unit = twinhub_linear::unit(symbol).unwrap_or("");
                text += &format!("  {symbol:<5} {value:<14} {unit}\n");
            }
        }
        Bicycle::Multibody(parameters) => {
            for e in parameters.entries() {
                let (path, value) = (&e.path, e.value.to_string());
                text += &format!("  {path:<52} {value:<22} {}\n", multibody::unit(path));
            }
            text += &format!("`twinhub bicycle {name}` prints its file.");
        }
    }
    Some(text)
}

/// A parameter by its path or symbol.
fn parameter_text(name: &str) -> Option<String> {
    if let Some(unit) = twinhub_linear::unit(name) {
        return Some(format!(
            "parameter {name} of linear bicycles, {unit}: symbol of Meijaard et al. (2007), table 1"
        ));
    }
    let none: [&str; 0] = [];
    let full = bicycles::load_multibody(multibody_sets::FULL, &none).ok()?;
    let value = full.entry(name)?;
    Some(format!(
        "parameter {name}: {}\nUnit: {}\nIn {}: {value}\nSource: {}",
        multibody::meaning(name)?,
        multibody::unit(name),
        full.name,
        full.source
    ))
}

/// Prints what `name` means.
///
/// # Errors
/// If nothing has that name.
pub fn explain(args: &ExplainArgs) -> anyhow::Result<ExitCode> {
    let texts = explanations(&args.name);
    if texts.is_empty() {
        return Err(bad_input(anyhow!(
            "nothing is called `{}`; `twinhub list` prints every name",
            args.name
        )));
    }
    println!("{}", texts.join("\n\n"));
    Ok(ExitCode::SUCCESS)
}
