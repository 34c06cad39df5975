"""Shot peening from the nozzle to the residual stress: YADE, FreeFEM and what carries data between them."""
