### Les phrases du programme du drone en français, dans la syntaxe de Fluent. drone-en.ftl (écrit par
### packaging/sentences.py) les donne en anglais : mêmes codes, mêmes valeurs.
###
### Les mêmes termes que dans fr.ftl.

autopilot-fault = L'autopilote signale une panne : { $words }
autopilot-says = L'autopilote : { $words }
autopilot-warns = L'autopilote avertit : { $words }
east = est
full-stop = { $text }.
metres = { $value }{ "\u00A0" }m
north = nord
north-east = nord-est
north-west = nord-ouest
seconds = { $value }{ "\u00A0" }s
south = sud
south-east = sud-est
south-west = sud-ouest
two-sentences = { $first } { $second }
west = ouest
