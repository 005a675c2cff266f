"""The public names and their types; `__init__.py` loads each when it is first used."""

from nlds_vines.archives.archive import read as read
from nlds_vines.bifurcation.command import scan as scan
from nlds_vines.bifurcation.request import Scan as Scan
from nlds_vines.bifurcation.request import load_scan as load_scan
from nlds_vines.bifurcation.response_curves import ResponseCurves as ResponseCurves
from nlds_vines.bifurcation.response_curves import response_curves as response_curves
from nlds_vines.bifurcation.result import ScanArchive as ScanArchive
from nlds_vines.bifurcation.result import orbit_of as orbit_of
from nlds_vines.continuation.command import continue_branch as continue_branch
from nlds_vines.continuation.request import Continuation as Continuation
from nlds_vines.continuation.request import load_continuation as load_continuation
from nlds_vines.continuation.result import Continued as Continued
from nlds_vines.errors import RequestError as RequestError
from nlds_vines.loads.command import response_history as response_history
from nlds_vines.loads.request import HistoryRequest as HistoryRequest
from nlds_vines.loads.request import load_response_history as load_response_history
from nlds_vines.loads.response_spectrum import ResponseSpectrum as ResponseSpectrum
from nlds_vines.loads.response_spectrum import response_spectrum as response_spectrum
from nlds_vines.loads.result import LoadScan as LoadScan
from nlds_vines.loads.result import ResponseHistories as ResponseHistories
from nlds_vines.model.catalog import load_system as load_system
from nlds_vines.model.slow_manifold import SlowManifold as SlowManifold
from nlds_vines.model.slow_manifold import slow_manifold as slow_manifold
from nlds_vines.model.system import System as System
from nlds_vines.orbits.classification import LyapunovSpectrum as LyapunovSpectrum
from nlds_vines.orbits.classification import Regime as Regime
from nlds_vines.orbits.classification import classify as classify
from nlds_vines.orbits.simulation import IntegrationError as IntegrationError
from nlds_vines.orbits.simulation import Orbit as Orbit
from nlds_vines.orbits.simulation import simulate as simulate
from nlds_vines.orbits.simulation import spectrum as spectrum
from nlds_vines.orbits.spectrum import Spectrum as Spectrum
from nlds_vines.portrait.command import orbit_portrait as orbit_portrait
from nlds_vines.transients.basins import Basins as Basins
from nlds_vines.transients.basins import basin_measures as basin_measures
from nlds_vines.transients.command import transient_lifetimes as transient_lifetimes
from nlds_vines.transients.ensemble import Ensemble as Ensemble
from nlds_vines.transients.ensemble import ensemble_of as ensemble_of
from nlds_vines.tuning.command import tune as tune
from nlds_vines.tuning.request import Tuning as Tuning
from nlds_vines.tuning.request import load_tuning as load_tuning
from nlds_vines.tuning.result import Tuned as Tuned
from nlds_vines.upkeep.plot import open_archive as open_archive
from nlds_vines.upkeep.plot import plot as plot

__version__: str
