"""What tests of meshed bodies share."""

import numpy as np
import pytest


@pytest.fixture
def elastic_law():
    """Stresses s_xx, s_yy, s_xy of plane stress or strain, or of a solid of revolution with the hoop last."""

    def elastic_law(youngs_modulus, poissons_ratio, plane_strain):
        E, nu = youngs_modulus, poissons_ratio
        shear = E / (2.0 * (1.0 + nu))
        if plane_strain is False:
            factor = E / (1.0 - nu * nu)
            return np.array([[factor, nu * factor, 0.0], [nu * factor, factor, 0.0], [0.0, 0.0, shear]])
        lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        direct = [0, 1] if plane_strain else [0, 1, 3]
        law = np.zeros((3, 3) if plane_strain else (4, 4))
        law[np.ix_(direct, direct)] = lame
        law[direct, direct] += 2.0 * shear
        law[2, 2] = shear
        return law

    return elastic_law
