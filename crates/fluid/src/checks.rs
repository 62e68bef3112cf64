//! All checks of the parameters of a fluid.

use crate::bodies::Contacts;
use crate::error::Error;
use crate::parameters::{Parameters, require_positive};
use crate::space::Space;

impl<const D: usize> Parameters<D>
where
    [f64; D]: Space<D>,
{
    /// Refuse numbers with which no step can be made.
    ///
    /// # Errors
    /// [`Error::Parameter`] and its like, with the number.
    pub fn check(&self) -> Result<(), Error> {
        const WIDTHS: [&str; 3] =
            ["width of the domain along x", "width of the domain along y", "width of the domain along z"];
        let widths = WIDTHS.into_iter().zip(self.domain.map(|[low, high]| high - low));
        let numbers = [
            ("density", self.density),
            ("kinematic viscosity", self.kinematic_viscosity),
            ("C_eta of the mask", self.mask.c_eta()),
            ("largest step", self.max_step),
            ("largest CFL number", self.max_cfl),
            ("communication step", self.communication_step),
        ];
        widths.chain(numbers).try_for_each(|(name, value)| require_positive(name, value))?;
        self.check_cells()?;
        self.check_boxes()?;
        self.bodies.iter().try_for_each(|body| self.check_body(body))?;
        Contacts::new(self)?;
        self.flexible.iter().try_for_each(|body| self.check_flexible(body))
    }
}
