//! The plants: those of CATAMARAN_DATA (default ../shared) if it exists, and generated ones.

use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{Plant, WaterModel, WaterOptions, read};

use crate::Result;

/// A plant and its water.
pub struct Subject {
    /// Its name.
    pub name: String,
    /// The plant.
    pub plant: Plant,
    /// Its model with the default constants.
    pub model: WaterModel,
}

impl Subject {
    /// Creates the model of a plant with the default constants.
    ///
    /// # Errors
    /// The errors of the model.
    pub fn new(name: String, plant: Plant) -> Result<Self> {
        let model = WaterModel::new(&plant, &WaterOptions::default())?;
        Ok(Self { name, plant, model })
    }

    /// Returns the time at which about half of the water is lost, in seconds.
    pub fn half_time(&self) -> f64 {
        let full = self.model.full();
        let lost: f64 = full.iter().zip(self.model.losses()).map(|(m, l)| m * l).sum();
        std::f64::consts::LN_2 * full.iter().sum::<f64>() / lost
    }
}

/// Returns all plants, of 300 to 2,000 nodes as in the thesis, a generated one first.
///
/// # Errors
/// When a file exists and can't be read.
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
