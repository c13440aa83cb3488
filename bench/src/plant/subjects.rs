//! The plants: those of CATAMARAN_DATA (default ../shared) if it is there, and generated ones.

use catamaran::plant::families::{GrowthOptions, grow};
use catamaran::plant::{Plant, WaterModel, WaterOptions, read};

use crate::Result;

/// A plant and its water.
pub struct Subject {
    /// Its name.
    pub name: String,
    /// Itself.
    pub plant: Plant,
    /// With the default constants.
    pub model: WaterModel,
}

impl Subject {
    /// A plant with the default constants.
    ///
    /// # Errors
    /// Those of the model.
    pub fn new(name: String, plant: Plant) -> Result<Self> {
        let model = WaterModel::new(&plant, &WaterOptions::default())?;
        Ok(Self { name, plant, model })
    }

    /// When about half of the water is gone, in seconds.
    pub fn half_time(&self) -> f64 {
        let full = self.model.full();
        let lost: f64 = full.iter().zip(self.model.losses()).map(|(m, l)| m * l).sum();
        std::f64::consts::LN_2 * full.iter().sum::<f64>() / lost
    }
}

/// All of them, of 300 to 2,000 nodes as in the thesis, a generated one first.
///
/// # Errors
/// When a file that is there can't be read.
pub fn subjects() -> Result<Vec<Subject>> {
    let grown = grow(&GrowthOptions::new().nodes(1000))?;
    let mut subjects = vec![Subject::new("grown".into(), grown)?];
    let data = crate::input::data_folder();
    for number in ["002", "001", "003", "000"] {
        let path = data.join(format!("plants/plant{number}.txt"));
        if path.is_file() {
            subjects.push(Subject::new(format!("plant{number}"), read(&path)?)?);
        }
    }
    Ok(subjects)
}
