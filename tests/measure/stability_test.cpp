#include "measure/stability.h"
