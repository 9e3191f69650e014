//! The stabilizer on tyres: jumps of friction, what it knows of its roll, and hours of use.

mod belief;
mod friction_jumps;
mod long_ride;
mod roll_estimate;

use twinhub_plant::road::Road;
use twinhub_sim::Ride;
use twinhub_sim::plant::PlantChoice;

/// Puts another road under a ride of the multibody bicycle.
fn lay_road(ride: &mut Ride, road: Road) {
    let PlantChoice::Multibody(plant) = &mut ride.course.plant else {
        panic!("the course rides the multibody bicycle")
    };
    plant.road = road.into();
}
