"""How stiff the contacts of wheels and rails are: adhesion over creep, as long as the two are proportional."""

SOFTEST = 20.0  # of any: what creeps more under its adhesion is near the peak, where they no longer are
SOFT = 30.0  # hardly any in service is softer
USUAL_STIFFNESS = 60.0  # within a factor of two to three
USUALLY_STIFFEST = 100.0  # of most
STIFFEST = 200.0  # of any
