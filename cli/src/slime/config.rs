//! Reads the configuration of a simulation: a TOML file with the names of table 3.1, or an .ini of
//! the reference implementation. The file is also part of a fuzz target, so that it uses nothing of
//! the command line but [`super::look`].

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use catamaran_simulation::texture::slime::{Blur, Options, TangentStep};
use serde::Deserialize;

use super::look::LookConfig;

/// Substeps of projected steps, if the file gives no number.
const SUBSTEPS: u32 = 10;

/// The names and units of [`Options`], and the look of materials.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    agents: Option<usize>,
    species: Option<usize>,
    size: Option<usize>,
    seed: Option<u32>,
    time_step: Option<f64>,
    movement_speed: Option<f64>,
    turn_speed: Option<f64>,
    vision_distance: Option<f64>,
    vision_angle: Option<f64>,
    evaporation_rate: Option<f64>,
    diffusion_rate: Option<f64>,
    turn_noise: Option<f64>,
    tangent_step: Option<Step>,
    substeps: Option<u32>,
    blur: Option<Spread>,
    length_rescaling: Option<bool>,
    material: Option<LookConfig>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Step {
    Unfold,
    Project,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Spread {
    Gaussian,
    SeamAware,
}

/// The settings of a file, and the names of settings that have no counterpart here.
#[derive(Debug, PartialEq)]
pub struct Loaded {
    pub options: Options,
    pub look: Option<LookConfig>,
    pub without_effect: Vec<String>,
}

/// Reads a configuration; settings that are missing have their defaults.
pub fn load(path: &Path) -> Result<Loaded> {
    let named = || path.display().to_string();
    let text = fs::read_to_string(path).map_err(|e| catamaran::Error::io(path, e))?;
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ini")) {
        reference(&text).with_context(named)
    } else {
        toml(&text).with_context(named)
    }
}

fn toml(text: &str) -> Result<Loaded> {
    let config: Config = toml::from_str(text).map_err(|error| {
        let before = text.get(..error.span().map_or(0, |span| span.start)).unwrap_or(text);
        anyhow!("line {}: {}", before.matches('\n').count() + 1, error.message())
    })?;
    let default = Options::default();
    let tangent_step = match (config.tangent_step, config.substeps) {
        (Some(Step::Project), substeps) => {
            TangentStep::Project { substeps: substeps.unwrap_or(SUBSTEPS) }
        }
        (_, Some(_)) => bail!("substeps: only with tangent_step = \"project\""),
        (_, None) => TangentStep::Unfold,
    };
    let options = Options::new()
        .agents(config.agents.unwrap_or(default.agents))
        .species(config.species.unwrap_or(default.species))
        .size(config.size.unwrap_or(default.size))
        .seed(config.seed.unwrap_or(default.seed))
        .time_step(config.time_step.unwrap_or(default.time_step))
        .movement_speed(config.movement_speed.unwrap_or(default.movement_speed))
        .turn_speed(config.turn_speed.unwrap_or(default.turn_speed))
        .vision_distance(config.vision_distance.unwrap_or(default.vision_distance))
        .vision_angle(config.vision_angle.unwrap_or(default.vision_angle))
        .evaporation_rate(config.evaporation_rate.unwrap_or(default.evaporation_rate))
        .diffusion_rate(config.diffusion_rate.unwrap_or(default.diffusion_rate))
        .turn_noise(config.turn_noise.unwrap_or(default.turn_noise))
        .tangent_step(tangent_step)
        .blur(match config.blur {
            Some(Spread::Gaussian) => Blur::Gaussian,
            Some(Spread::SeamAware) => Blur::SeamAware,
            None => default.blur,
        })
        .length_rescaling(config.length_rescaling.unwrap_or(default.length_rescaling));
    options.check()?;
    if let Some(look) = &config.material {
        look.look(None).context("material")?;
    }
    Ok(Loaded { options, look: config.material, without_effect: Vec::new() })
}

/// Reads the .ini of the thesis' implementation (github.com/filthynobleman/slime-manifold,
/// data/configs): lengths are parts of the side of the texture, the turn speed is in half-turns per
/// second.
fn reference(text: &str) -> Result<Loaded> {
    let mut options = Options::default();
    let (mut without_effect, mut seen) = (Vec::new(), HashSet::new());
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with([';', '#', '[']) {
            continue;
        }
        let Some((key, value)) = line.split_once('=').map(|(k, v)| (k.trim(), v.trim())) else {
            bail!("line {number}: {line:?} is not of the form NAME=VALUE");
        };
        if !seen.insert(key) {
            bail!("line {number}: {key} is there twice");
        }
        let real = || value.parse::<f64>().with_context(|| format!("line {number}: {key}"));
        let count = || value.parse::<usize>().with_context(|| format!("line {number}: {key}"));
        match key {
            "NumAgents" => options.agents = count()?,
            "NumSpecies" => options.species = count()?,
            "MoveSpeed" => options.movement_speed = 100.0 * real()?,
            "TurnSpeed" => options.turn_speed = 180.0 * real()?,
            "VisionAngle" => options.vision_angle = real()?,
            "VisionDist" => options.vision_distance = 100.0 * real()?,
            "DecayRate" => options.evaporation_rate = real()?,
            "DiffuseRate" => options.diffusion_rate = real()?,
            // Steps are exact here, sensors are points of a blurred texture, and an agent deposits
            // 1.
            "MoveStep" | "SensorRadius" | "TrailWeight" | "StepsPerFrame" => {
                real()?;
                without_effect.push(key.to_owned());
            }
            _ => bail!("line {number}: unknown name {key:?}"),
        }
        options.check().with_context(|| format!("line {number}: {key}={value}"))?;
    }
    Ok(Loaded { options, look: None, without_effect })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read() {
        let text = "agents = 5\nspecies = 3\nsize = 64\nseed = 9\ntime_step = 0.1\nmovement_speed = 1.25\n\
            turn_speed = 900\nvision_distance = 0.5\nvision_angle = 20.5\nevaporation_rate = 0.25\ndiffusion_rate = 3\n\
            turn_noise = 0.5\ntangent_step = \"project\"\nsubsteps = 7\nblur = \"gaussian\"\nlength_rescaling = false\n";
        let expected = Options::new()
            .agents(5)
            .species(3)
            .size(64)
            .seed(9)
            .time_step(0.1)
            .movement_speed(1.25)
            .turn_speed(900.0)
            .vision_distance(0.5)
            .vision_angle(20.5)
            .evaporation_rate(0.25)
            .diffusion_rate(3.0)
            .turn_noise(0.5)
            .tangent_step(TangentStep::Project { substeps: 7 })
            .blur(Blur::Gaussian)
            .length_rescaling(false);
        let plain = |options| Loaded { options, look: None, without_effect: Vec::new() };
        assert_eq!(toml(text).unwrap(), plain(expected));
        assert_eq!(toml("").unwrap(), plain(Options::default()));
        assert_eq!(toml("[material]").unwrap().look, Some(LookConfig::default()));
    }

    #[test]
    fn unknown_names_and_wrong_values_are_named() {
        for (text, name) in [
            ("vision_angel = 3", "vision_angel"),
            ("vision_angle = 200", "vision_angle"),
            ("size = 100", "size"),
            ("substeps = 4", "substeps"),
            ("blur = \"box\"", "box"),
            ("[material]\nlock = \"gold\"", "lock"),
            ("[material]\nlook = \"silver\"", "silver"),
        ] {
            let error = format!("{:#}", toml(text).unwrap_err());
            assert!(error.contains(name), "{error}");
        }
    }

    #[test]
    fn files_of_the_reference_are_read() {
        let text = "NumAgents=1000\nNumSpecies=3\nMoveSpeed=0.01\nMoveStep=0.0001\nTurnSpeed=50.0\n\
            VisionAngle=45.0\nVisionDist=0.015\nSensorRadius=1\nDecayRate=0.3\nDiffuseRate=4.0\n";
        let loaded = reference(text).unwrap();
        assert_eq!(loaded.without_effect, ["MoveStep", "SensorRadius"]);
        let o = loaded.options;
        assert_eq!((o.agents, o.species, o.turn_speed), (1000, 3, 9000.0));
        assert_eq!((o.movement_speed, o.vision_distance, o.vision_angle), (1.0, 1.5, 45.0));
        assert_eq!((o.evaporation_rate, o.diffusion_rate), (0.3, 4.0));
        let error = reference("NumAgents=3\n[Other]\nNumAgents=4").unwrap_err().to_string();
        assert!(error.contains("line 3: NumAgents is there twice"), "{error}");
        let error = reference("NumAgent=3").unwrap_err().to_string();
        assert!(error.contains("line 1") && error.contains("NumAgent"), "{error}");
        let error = format!("{:#}", reference("NumSpecies=3\nMoveSpeed=-1").unwrap_err());
        let why = "line 2: MoveSpeed=-1: movement_speed: must be from 0 to 1000000, is -100";
        assert_eq!(error, why);
    }
}
