//! Looks of materials, as the configuration describes them. The file is also part of a fuzz target,
//! so that it uses nothing of the command line.

use anyhow::{Result, anyhow, bail};
use catamaran_simulation::texture::{Finish, Look, Preset};
use serde::Deserialize;

/// The table `[material]` of a configuration: differences from a named look.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookConfig {
    look: Option<String>,
    mask: Option<[f64; 2]>,
    depth: Option<f64>,
    smoothing: Option<u32>,
    #[serde(default)]
    bare: FinishConfig,
    #[serde(default)]
    species: Vec<FinishConfig>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct FinishConfig {
    color: Option<String>,
    roughness: Option<f64>,
    metalness: Option<f64>,
    height: Option<f64>,
    glow: Option<f64>,
}

/// Returns the look with this name.
pub fn named(name: &str) -> Result<Preset, String> {
    let found = Preset::ALL.into_iter().find(|(known, _)| *known == name);
    found.map(|(_, preset)| preset).ok_or_else(|| {
        let known = Preset::ALL.map(|(known, _)| known).join(", ");
        format!("no look is called {name:?}; the looks are {known}")
    })
}

impl LookConfig {
    /// Returns the described look; `preset`, of the command line, replaces the look that the file
    /// names.
    pub fn look(&self, preset: Option<Preset>) -> Result<Look> {
        let own = self.look.as_deref().map(named).transpose().map_err(|e| anyhow!("look: {e}"))?;
        let mut look = Look::of(preset.or(own).unwrap_or_default());
        look.mask = self.mask.unwrap_or(look.mask);
        look.depth = self.depth.unwrap_or(look.depth);
        look.smoothing = self.smoothing.unwrap_or(look.smoothing);
        look.bare = self.bare.over(look.bare)?;
        let known = look.species.clone();
        for (s, config) in self.species.iter().enumerate() {
            // For more species the finishes of a look repeat from the first.
            let finish = config.over(known[s % known.len()])?;
            match look.species.get_mut(s) {
                Some(own) => *own = finish,
                None => look.species.push(finish),
            }
        }
        look.check()?;
        Ok(look)
    }
}

impl FinishConfig {
    fn over(&self, finish: Finish) -> Result<Finish> {
        let color = self.color.as_deref().map(color).transpose()?;
        Ok(finish
            .color(color.unwrap_or(finish.color))
            .roughness(self.roughness.unwrap_or(finish.roughness))
            .metalness(self.metalness.unwrap_or(finish.metalness))
            .height(self.height.unwrap_or(finish.height))
            .glow(self.glow.unwrap_or(finish.glow)))
    }
}

/// Parses a colour as style sheets write it: `#rrggbb`.
fn color(text: &str) -> Result<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii());
    let byte = |k: usize| u8::from_str_radix(digits?.get(2 * k..2 * k + 2)?, 16).ok();
    match [0, 1, 2].map(byte) {
        [Some(r), Some(g), Some(b)] => Ok([r, g, b]),
        _ => bail!("color: {text:?} is not a colour such as \"#ffcd50\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says_goes_over_the_look_it_names() {
        let text = "look = \"gold\"\ndepth = 2\nbare = { color = \"#010203\" }\n\
            species = [{ roughness = 0.5 }, {}, { color = \"#FFffFF\", glow = 1 }]";
        let config: LookConfig = toml::from_str(text).unwrap();
        let (look, gold) = (config.look(None).unwrap(), Look::of(Preset::Gold));
        assert_eq!((look.depth, look.mask, look.smoothing), (2.0, gold.mask, gold.smoothing));
        assert_eq!(look.bare, gold.bare.color([1, 2, 3]));
        assert_eq!(look.species[0], gold.species[0].roughness(0.5));
        assert_eq!(look.species[1], gold.species[1]);
        assert_eq!(look.species[2], gold.species[0].color([255; 3]).glow(1.0));
        // The command line goes before the name, not before the rest.
        let wood = config.look(Some(Preset::Wood)).unwrap();
        assert_eq!((wood.mask, wood.depth), (Look::of(Preset::Wood).mask, 2.0));
        assert_eq!(LookConfig::default().look(None).unwrap(), Look::default());
    }

    #[test]
    fn wrong_looks_and_colours_are_named() {
        for (text, name) in [
            ("look = \"silver\"", "silver"),
            ("bare = { color = \"red\" }", "red"),
            ("bare = { color = \"#12345g\" }", "#12345g"),
            ("species = [{ roughness = 3 }]", "roughness"),
            ("mask = [0.5, 0.1]", "mask"),
        ] {
            let config: LookConfig = toml::from_str(text).unwrap();
            let error = format!("{:#}", config.look(None).unwrap_err());
            assert!(error.contains(name), "{error}");
        }
    }
}
