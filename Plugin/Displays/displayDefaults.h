// SPDX-License-Identifier: BSD-3-Clause
/**
 * What ParaView shows of our outputs before anything was chosen, and tells of our filters; called when the plugin is
 * loaded.
 */
#ifndef displayDefaults_h
#define displayDefaults_h

#include "BSplineVolumeDisplaysModule.h" // For export macro

namespace bsv
{

/**
 * In clients, reads BSplineVolumeSettings.json from the folder of this library: colour tables per array name and
 * properties of displays. They weigh less than the settings of user and site, and are not saved with them. Without the
 * file ParaView's own defaults hold.
 */
BSPLINEVOLUMEDISPLAYS_EXPORT void loadDisplayDefaults();

/**
 * In ParaView's window, loads the plugin BSplineVolumeQt from the folder BSplineVolumeQt beside this library. Servers
 * and Python have no such window and load nothing of Qt; without the file ParaView's own widgets are used.
 */
BSPLINEVOLUMEDISPLAYS_EXPORT void loadQtPart();

/**
 * In clients, information properties of registered proxies with the hint InformationAfterUpdate are up to date after
 * every update: a script reads reports and counts without calling UpdatePropertyInformation() before.
 */
BSPLINEVOLUMEDISPLAYS_EXPORT void keepInformationUpToDate();

} // namespace bsv

#endif
